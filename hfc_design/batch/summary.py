"""What runs give: groups that differ in nothing but the seed, how their scores compare, which
structures won, and the published figures that they stand beside. At a terminal, too.
"""

from pathlib import Path
from typing import NamedTuple

from rich.text import Text

from hfc_design.batch.comparisons import Comparison, broken, compared, sentence
from hfc_design.batch.groups import ANSWERS, Group, grouped
from hfc_design.batch.published import Reproduced, reproduced
from hfc_design.batch.runs import Run
from hfc_design.batch.structures import Winner, tell_structures, winners
from hfc_design.core.console import show_rows, terminal
from hfc_design.core.records import harmless
from hfc_design.core.shown import line, table

#: Of so many groups a notebook has the median.
SHOWN = 12
#: Of so many tasks, and groups of each, the medians are told.
TASKS, GROUPS = 6, 10
HEAD = ["group", "runs", "median", "quartiles", "best"]


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


def tell(page: Path, found: Findings | None) -> None:
    """Print what the runs gave, if it is more than one, and where the page is."""
    if found is not None:
        tasks = list(dict.fromkeys(group.task for group in found.groups))
        for task in tasks[:TASKS]:
            groups = [group for group in found.groups if group.task == task]
            _show(groups)
            terminal().print(Text(harmless(sentence(groups, found.comparisons))))
            if failed := broken(groups):
                terminal().print(Text(harmless(failed)))
            terminal().print()
        if len(tasks) > TASKS:
            terminal().print(f"{len(tasks) - TASKS} more tasks are in groups.csv\n")
        tell_structures(found.winners)
    print(page)


def _show(groups: list[Group]) -> None:
    """The medians of a task over the seeds, the highest first."""
    title = f"{groups[0].task}: {groups[0].measure}"
    heads = [*HEAD, *(ANSWERS if groups[0].answers else [])]
    cells = ([harmless(group.label), *group.row()[1:]] for group in groups[:GROUPS])
    show_rows(heads, (map(Text, row) for row in cells), title=Text(harmless(title)), title_style="")
    if len(groups) > GROUPS:
        terminal().print(f"{len(groups) - GROUPS} more groups are in groups.csv")
