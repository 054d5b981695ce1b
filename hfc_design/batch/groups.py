"""Runs that differ in nothing but the seed belong together: their scores, metrics, structures."""

import sys
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np
from rich.text import Text

from hfc_design.batch.plan import SCENARIO
from hfc_design.batch.runs import VERDICTS, Run
from hfc_design.core.console import show_rows, terminal
from hfc_design.core.numbers import Floats
from hfc_design.core.records import UserError, harmless, in_a_line
from hfc_design.core.shown import line
from hfc_design.core.statistics import Interval, share_interval
from hfc_design.files.cells import LABEL, SEED
from hfc_design.files.design import Design
from hfc_design.files.pairing import load_design
from hfc_design.pictures.numbers import score
from hfc_design.pictures.section import Drawing
from hfc_design.report.designs import picture
from hfc_design.runs.champion import LEAST_VIOLATED

#: What is compared: the merit, or the fitness where runs of a task were not all judged alike.
MERIT, FITNESS = "merit", "fitness"
#: What keys begin with that the fitness depends on.
OF_FITNESS = "fitness."
#: What tables call ``Group.answers``.
ANSWERS = ["usable", "pass [%]"]
Quartiles = tuple[float, float, float]
STRUCTURES = "structures.csv"
STRUCTURE, GROUP = "structure", "group"
#: Of the page; at a terminal each group has a table of its own.
WINNER_HEAD = [STRUCTURE, GROUP, "runs", "share [%]", "best", "median"]
#: At a terminal so many structures of a group are told, and of so many groups.
LISTED, TABLES = 3, 6
#: Of so many groups the most frequent structure is drawn: of those that come first.
DRAWN = 6


class Group(NamedTuple):
    """Runs with the same settings and different seeds."""

    number: int  # from 1; what tables and pictures call it
    task: str  # what the score is of; scores of different tasks do not compare
    measure: str  # what is compared: title of the merit of all runs of the task, or fitness
    settings: dict[str, str]  # those that differ somewhere among all groups
    runs: list[Run]
    finished: list[Run]  # one a seed: run again, it would give the same and tell nothing more
    scores: Floats  # (finished,) in float64; -inf where a design diverged
    quartiles: Quartiles  # of the scores; nan without a finished run

    def __repr__(self) -> str:
        told = {"label": self.label, "task": self.task, "measure": self.measure}
        return line("Group", {**told, "median": self.median, "finished": len(self.finished)})

    @property
    def key(self) -> str:
        """Which of the numbers of a run is compared."""
        return FITNESS if self.measure == FITNESS else MERIT

    @property
    def median(self) -> float:
        """Median of the final score."""
        return self.quartiles[1]

    @property
    def broken(self) -> int:
        """How many finished runs found no design that keeps every constraint."""
        return sum(bool(run.score.get(LEAST_VIOLATED)) for run in self.finished)

    @property
    def answers(self) -> list[str]:
        """How many seeds have a usable design, and the median share that passes [%]; or nothing."""
        yes, _, share = self._judged
        asked = sum(bool(run.use.verdict) for run in self.finished)
        return [f"{round(yes * asked)} of {asked}", f"{100 * share:.4g}"] if asked else []

    @property
    def place(self) -> tuple[float, ...]:
        """Among groups of its task, the best first: by verdicts, share, median score."""
        return *(-x for x in self._judged), np.isnan(self.median), -self.median

    @property
    def _judged(self) -> tuple[float, ...]:
        """Shares of the two best verdicts, and the median share of machines; 0 if nobody asked."""
        told = [run.use for run in self.finished if run.use.verdict]
        best = (sum(one.verdict == x for one in told) / max(len(told), 1) for x in VERDICTS[:2])
        return *best, float(np.median([one.share or 0.0 for one in told] or [0.0]))

    def row(self, keys: Iterable[str] = ()) -> list[str]:
        """As tables have it: number, settings, runs, median, quartiles, best, how usable."""
        own, count, total = (self.settings[key] for key in keys), len(self.finished), len(self.runs)
        row = [str(self.number), *own, str(total) if count == total else f"{count} of {total}"]
        if not self.finished:
            return [*row, "–", "–", "–"]
        low, median, high = map(score, self.quartiles)
        return [*row, median, f"{low} to {high}", score(self.scores.max()), *self.answers]

    def metrics(self) -> dict[str, Quartiles]:
        """Quartiles of each metric over the finished runs that have it."""
        values: dict[str, list[float]] = defaultdict(list)
        for run in self.finished:
            for key, value in run.score.items():
                if value is not None and key != LEAST_VIOLATED:
                    values[key].append(value)
        return {key: quartiles(np.array(found)) for key, found in values.items()}

    @property
    def label(self) -> str:
        """Its number and what sets it apart from the other groups of its task."""
        named = (k for k in self.settings if k != SCENARIO and not k.startswith(OF_FITNESS))
        own = [f"{key.rpartition('.')[2]} {self.settings[key]}" for key in named]
        if LABEL in self.settings:
            own = [self.settings[LABEL]]
        return f"{self.number}: {', '.join(own)}" if own else str(self.number)


def grouped(runs: Sequence[Run]) -> list[Group]:
    """The groups, task by task, the best first: see ``Group.place``."""
    known = [run for run in runs if run.settings]
    keys = dict.fromkeys(key for run in known for key in run.settings if key != SEED)
    differing = [key for key in keys if len({run.setting(key) for run in known}) > 1]
    tasks: dict[str, dict[tuple[str, ...], list[Run]]] = {}
    for run in known:
        # The scenario, and what else the fitness depends on.
        own = [f"{key} {run.setting(key)}" for key in differing if key.startswith(OF_FITNESS)]
        members = tasks.setdefault(", ".join([run.setting(SCENARIO), *own]), {})
        members.setdefault(tuple(run.setting(key) for key in differing), []).append(run)
    found: list[Group] = []
    for task, members in tasks.items():
        finished = [run for inside in members.values() for run in inside if run.state == "finished"]
        judge, *others = {run.judged_by for run in finished} or {FITNESS}
        # Runs of an earlier version do not name their judge.
        measure = FITNESS if others else judge or FITNESS
        groups = [
            _group(task, measure, dict(zip(differing, own, strict=True)), inside)
            for own, inside in members.items()
        ]
        found += sorted(groups, key=lambda group: group.place)
    return [group._replace(number=k) for k, group in enumerate(found, 1)]


def _group(task: str, measure: str, settings: dict[str, str], runs: list[Run]) -> Group:
    once: dict[str, Run] = {}
    for run in runs:
        if run.state == "finished":
            once.setdefault(run.setting(SEED), run)
    group = Group(0, task, measure, settings, runs, list(once.values()), np.empty(0), (np.nan,) * 3)
    found = [run.score.get(group.key) for run in group.finished]
    scores = np.array([-np.inf if value is None else value for value in found], float)
    return group._replace(scores=scores, quartiles=quartiles(scores))


def quartiles(values: Floats) -> Quartiles:
    """Lower quartile, median and upper quartile, which may be -inf; nan of nothing."""
    if not len(values):
        return np.nan, np.nan, np.nan
    with np.errstate(invalid="ignore"):  # between -inf and what is finite
        found = np.quantile(values, (0.25, 0.5, 0.75))
    low, median, high = np.nan_to_num(found, nan=-np.inf, neginf=-np.inf).tolist()
    return low, median, high


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
    def row(self) -> list[str]:
        """What a reader sees of it, as in ``WINNER_HEAD``."""
        low, high = (100 * end for end in self.interval)
        share = f"{100 * self.share:.0f} ({low:.0f} to {high:.0f})"
        which = [self.structure, str(self.group.number), f"{len(self.runs)} of {self.searches}"]
        return [*which, share, score(self.best), score(self.median)]

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


def structure_rows(found: Iterable[Winner]) -> Iterable[list[object]]:
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
        places = [k for k, name in enumerate(WINNER_HEAD) if name != GROUP]
        each = (WINNER_HEAD, *(one.row for one in inside))
        heads, *rows = ([cells[k] for k in places] for cells in each)
        texts = (map(Text, cells) for cells in rows)
        show_rows(heads, texts, title=Text(harmless(label)), title_style="")
        terminal().print()
    if others := len(found) - sum(map(len, shown)):
        terminal().print(f"{others} more structures are in {STRUCTURES}")


def trees_of(path: Path, found: Sequence[Winner]) -> list[Drawing]:
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
