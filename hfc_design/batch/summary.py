"""What runs give: groups that differ in nothing but the seed, how their scores compare, which
structures won, and the published figures that they stand beside.
"""

from pathlib import Path
from typing import NamedTuple

from hfc_design.batch.comparisons import Comparison, compared
from hfc_design.batch.groups import Group, grouped
from hfc_design.batch.published import Reproduced, reproduced
from hfc_design.batch.runs import Run
from hfc_design.batch.structures import Winner, winners
from hfc_design.core.shown import line, table

#: Of so many groups a notebook has the median.
SHOWN = 12


class Findings(NamedTuple):
    """What pages and tables tell of the runs below a folder."""

    runs: list[Run]
    groups: list[Group]  # runs that differ in nothing but the seed, the highest median first
    comparisons: list[Comparison]  # of every two groups of a task, with p
    figures: list[Reproduced]  # that a batch file names as published, beside what the runs give
    winners: list[Winner]  # structures that searches of hierarchies ended with

    def __repr__(self) -> str:
        return line("Findings", self._told())

    def _repr_html_(self) -> str:
        shown = {
            f"{one.task}, {one.label}": f"{one.measure} {one.median:.4g} in the median of "
            f"{len(one.finished)} finished runs"
            for one in self.groups[:SHOWN]
        }
        return table("Findings", self._told() | shown)

    def _told(self) -> dict[str, object]:
        return {field: len(value) for field, value in self._asdict().items()}

    def number_of(self) -> dict[str, int]:
        """Path of each run in a group -> the group's number."""
        return {run.path: group.number for group in self.groups for run in group.runs}


def findings(path: Path, runs: list[Run]) -> Findings:
    """What the runs below ``path`` give."""
    groups = grouped(runs)
    return Findings(runs, groups, compared(groups), reproduced(path, runs), winners(groups))
