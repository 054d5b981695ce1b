"""Which structures the searches of a group ended with: how many of its seeds, and how good.

And as a reader sees them: at a terminal, on the page, in the CSV file.
"""

import sys
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np
from rich.text import Text

from hfc_design.batch.groups import Group, quartiles
from hfc_design.batch.runs import Run
from hfc_design.core.console import show_rows, terminal
from hfc_design.core.numbers import Floats
from hfc_design.core.records import UserError, harmless, in_a_line
from hfc_design.core.shown import line
from hfc_design.core.statistics import Interval, share_interval
from hfc_design.files.design import Design
from hfc_design.files.pairing import load_design
from hfc_design.pictures.numbers import score
from hfc_design.pictures.section import Drawing
from hfc_design.report.designs import picture

STRUCTURES = "structures.csv"
STRUCTURE, GROUP = "structure", "group"
#: Of the page; at a terminal each group has a table of its own.
HEAD = [STRUCTURE, GROUP, "runs", "share [%]", "best", "median"]
#: At a terminal so many structures of a group are told, and of so many groups.
LISTED, TABLES = 3, 6
#: Of so many groups the most frequent structure is drawn: of those that come first.
DRAWN = 6


class Winner(NamedTuple):
    """A structure that searches of a group ended with."""

    group: Group
    structure: str  # as the genome tells it
    runs: list[Run]  # that ended with it, the best first
    scores: Floats  # (runs,) what the group is compared by; -inf where a design diverged
    searches: int  # finished ones of the group, one a seed, whose structure is known

    def __repr__(self) -> str:
        told = {"group": self.group.label, "structure": self.structure, "best": self.best}
        return line("Winner", {**told, "runs": len(self.runs), "searches": self.searches})

    @property
    def share(self) -> float:
        """Of the searches."""
        return len(self.runs) / self.searches

    @property
    def interval(self) -> Interval:
        """Where the share of all seeds lies, of which these are a sample."""
        return share_interval(len(self.runs), self.searches)

    @property
    def best(self) -> float:
        """The highest of the scores."""
        return float(self.scores[0])

    @property
    def median(self) -> float:
        """Of the scores."""
        return quartiles(self.scores)[1]


def winners(groups: Sequence[Group]) -> list[Winner]:
    """The structures of each group, the most frequent first, of equally frequent ones the best.

    A design that was given is no search's; a group whose kind has but one structure has none.
    """
    found: list[Winner] = []
    for group in groups:
        members: dict[str, list[tuple[float, Run]]] = defaultdict(list)
        for run, value in zip(group.finished, group.scores.tolist(), strict=True):
            if run.searched and run.structure:
                members[run.structure].append((value, run))
        searches = sum(map(len, members.values()))
        own = []
        for structure, inside in members.items():
            scores, runs = zip(*sorted(inside, key=lambda pair: -pair[0]), strict=True)
            own.append(Winner(group, structure, list(runs), np.array(scores), searches))
        found += sorted(own, key=lambda one: (-len(one.runs), -one.best, one.structure))
    return found


def row(one: Winner) -> list[str]:
    """What a reader sees of a structure, as in ``HEAD``."""
    low, high = (100 * end for end in one.interval)
    share = f"{100 * one.share:.0f} ({low:.0f} to {high:.0f})"
    which = [one.structure, str(one.group.number)]
    return [*which, f"{len(one.runs)} of {one.searches}", share, score(one.best), score(one.median)]


def csv_rows(found: Iterable[Winner]) -> Iterable[list[object]]:
    """All of it in full precision."""
    counted = ["runs", "searches", "share", "share_low", "share_high"]
    yield ["group", "task", "measure", "structure", *counted, "best", "median", "best_run"]
    for one in found:
        which = [one.group.number, one.group.task, one.group.measure, one.structure]
        shares = [len(one.runs), one.searches, one.share, *one.interval]
        yield [*which, *shares, one.best, one.median, one.runs[0].path]


def tell_structures(found: Sequence[Winner]) -> None:
    """Print the first structures of each group, if there are any."""
    groups: dict[int, list[Winner]] = {}
    for one in found:
        groups.setdefault(one.group.number, []).append(one)
    shown = [inside[:LISTED] for inside in groups.values()][:TABLES]
    for inside in shown:
        group = inside[0].group
        label = f"structures that won in {group.task}, group {group.label}"
        if group.broken:
            label += f"; {group.broken} of {len(group.finished)} runs break constraints"
        places = [k for k, name in enumerate(HEAD) if name != GROUP]
        heads, *rows = ([cells[k] for k in places] for cells in (HEAD, *map(row, inside)))
        texts = (map(Text, cells) for cells in rows)
        show_rows(heads, texts, title=Text(harmless(label)), title_style="")
        terminal().print()
    if others := len(found) - sum(map(len, shown)):
        terminal().print(f"{others} more structures are in {STRUCTURES}")


def trees(path: Path, found: Sequence[Winner]) -> list[Drawing]:
    """The most frequent structure of each of the first groups below ``path``.

    Drawn as its best run has it; not of a kind without such a picture, nor, which is said, where
    the design cannot be read here.
    """
    first = {one.group.number: one for one in reversed(found)}
    drawn = []
    for _, one in sorted(first.items())[:DRAWN]:
        try:
            design = load_design(str(path / one.runs[0].path))
        except UserError as error:
            told = f"hfc: warning: the structure of {one.runs[0].path} is not drawn"
            print(in_a_line(f"{told}: {error.lines[0]}"), file=sys.stderr)
            continue
        with suppress(UserError):
            drawn += list(_drawn(one, design))
    return drawn


def _drawn(one: Winner, design: Design) -> Iterator[Drawing]:
    """The tree of each axis that has one of its own."""
    parts = {part.kind.structure(part.controller): axis for axis, part in design.by_axis().items()}
    for axis in (axis for structure, axis in parts.items() if structure):
        which = f"group {one.group.label}" + (f", axis {axis}" if axis else "")
        count = f"{len(one.runs)} of {one.searches} searches ended with it, the best of them was"
        if len(one.runs) == 1 < one.searches:
            count = "no two searches ended with the same structure; this is that of the best,"
        told = f"{which[0].upper()}{which[1:]}: {count} {one.runs[0].path}, whose scales it has."
        yield Drawing(picture(design, "tree", axis=axis), f"Structure that won in {which}", told)
