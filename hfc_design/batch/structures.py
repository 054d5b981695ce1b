"""Structures that the searches of each group ended with, as rows, as text and drawn."""

import sys
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from hfc_design.batch.groups import Group, quartiles
from hfc_design.batch.results import Run
from hfc_design.core.numbers import Floats
from hfc_design.core.records import UserError, in_a_line
from hfc_design.core.statistics import Interval, share_interval
from hfc_design.core.tables import Table, line
from hfc_design.files.design import Design
from hfc_design.files.loop_setup import load_design
from hfc_design.plotting.numbers import score
from hfc_design.plotting.section import Drawing
from hfc_design.report.designs import picture

STRUCTURES = "structures.csv"
#: Heads of the columns of ``winner_table``.
WINNER_HEAD = ["structure", "group", "runs", "share [%]", "best", "median"]
WINNERS = (
    "The structures that the searches of each group ended with, one search per seed, the most "
    "frequent first; shares with 95 % confidence (Clopper and Pearson)."
)
#: Largest number of groups, the first ones, whose most frequent structure is drawn.
DRAWN = 6


class Winner(NamedTuple):
    """A structure that searches of a group ended with."""

    group: Group
    structure: str  # as text
    runs: list[Run]  # runs that ended with this structure, the best first
    scores: Floats  # (runs,) merit or fitness (``Group.key``); -inf where a design diverged
    searches: int  # number of the group's finished searches with a known structure, one per seed

    def __repr__(self) -> str:
        shown = {"group": self.group.label, "structure": self.structure, "best": self.best}
        return line("Winner", {**shown, "runs": len(self.runs), "searches": self.searches})

    @property
    def share(self) -> float:
        """Share of the searches that ended with the structure."""
        return len(self.runs) / self.searches

    @property
    def interval(self) -> Interval:
        """Confidence interval of the share that a search with every possible seed would give."""
        return share_interval(len(self.runs), self.searches)

    @property
    def best(self) -> float:
        """Highest of the scores."""
        return float(self.scores[0])

    @property
    def median(self) -> float:
        """Median of the scores."""
        return quartiles(self.scores)[1]

    @property
    def row(self) -> list[str]:
        """Row of a table with the columns ``WINNER_HEAD``."""
        low, high = (100 * end for end in self.interval)
        share = f"{100 * self.share:.0f} ({low:.0f} to {high:.0f})"
        which = [self.structure, str(self.group.number), f"{len(self.runs)} of {self.searches}"]
        return [*which, share, score(self.best), score(self.median)]


def winners(groups: Sequence[Group]) -> list[Winner]:
    """Return the structures of each group, the most frequent first; on a tie, the best first.

    Runs with a given design do not count, as they have no search. Kinds of controller with only
    one structure are left out.
    """
    best: list[Winner] = []
    for group in groups:
        members: dict[str, list[tuple[float, Run]]] = defaultdict(list)
        for run, value in zip(group.finished, group.scores.tolist(), strict=True):
            if run.searched and run.structure:
                members[run.structure].append((value, run))
        searches = sum(map(len, members.values()))
        of_group = []
        for structure, inside in members.items():
            scores, runs = zip(*sorted(inside, key=lambda pair: -pair[0]), strict=True)
            of_group.append(Winner(group, structure, list(runs), np.array(scores), searches))
        best += sorted(of_group, key=lambda x: (-len(x.runs), -x.best, x.structure))
    return best


def structure_rows(winners: Iterable[Winner]) -> Iterable[list[object]]:
    """Yield the head and the rows of ``structures.csv``, in full precision."""
    counted = ["runs", "searches", "share", "share_low", "share_high"]
    yield ["group", "task", "measure", "structure", *counted, "best", "median", "best_run"]
    for x in winners:
        which = [x.group.number, x.group.task, x.group.measure, x.structure]
        shares = [len(x.runs), x.searches, x.share, *x.interval]
        yield [*which, *shares, x.best, x.median, x.runs[0].path]


def winner_table(winners: Iterable[Winner], key: str = "") -> Table:
    """Return a table of structures; ``key`` explains the numbers of the groups."""
    return Table(WINNERS, WINNER_HEAD, [one.row for one in winners], key=key)


def trees_of(path: Path, winners: Sequence[Winner]) -> list[Drawing]:
    """Draw the most frequent structure of each of the first groups below ``path``.

    The drawing shows the structure's best run. Kinds of controller without such a picture are
    skipped; so are designs that cannot be read, with a warning.
    """
    first = {x.group.number: x for x in reversed(winners)}
    drawings = []
    for _, winner in sorted(first.items())[:DRAWN]:
        place = winner.runs[0].path
        try:
            design = load_design(str(path / place))
        except UserError as error:
            warning = f"hfc: warning: the structure of {place} is not drawn"
            print(in_a_line(f"{warning}: {error.lines[0]}"), file=sys.stderr)
            continue
        with suppress(UserError):
            drawings += list(_trees(winner, design))
    return drawings


def _trees(winner: Winner, design: Design) -> Iterator[Drawing]:
    """Yield the trees of the winner's best design; axes with the same tree are drawn once."""
    runs, searches = winner.runs, winner.searches
    parts: dict[Any, list[str]] = {}
    for axis, part in design.by_axis().items():
        parts.setdefault(part.kind.structure(part.controller), []).append(axis)
    for axes in (axes for structure, axes in parts.items() if structure):
        axis = axes[0]
        names = f", {'axes' if len(axes) > 1 else 'axis'} {' and '.join(axes)}"
        which = f"group {winner.group.label}" + names * bool(axis)
        count = f"{len(runs)} of {searches} searches ended with this structure, the best of them"
        if len(runs) == 1 < searches:
            count = "no two searches ended with the same structure; this is the best one's,"
        text = (
            f"{which[0].upper()}{which[1:]}: {count} {runs[0].path}; the scales are those of "
            "that run."
        )
        yield Drawing(picture(design, "tree", axis=axis), f"Best structure of {which}", text)
