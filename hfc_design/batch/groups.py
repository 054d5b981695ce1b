"""Groups of runs that differ only in the seed, with their scores and metrics."""

from collections import defaultdict
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hfc_design.batch.plan import SCENARIO
from hfc_design.batch.results import VERDICTS, Run
from hfc_design.core.numbers import Floats
from hfc_design.core.tables import MISSING, Table, line
from hfc_design.files.labels import LABEL, SEED
from hfc_design.plotting.numbers import score
from hfc_design.runs.champion import LEAST_VIOLATED

#: Keys of the compared number: the merit, or the fitness if runs of a task have different merits.
MERIT, FITNESS = "merit", "fitness"
#: Prefix of the keys on which the fitness depends.
OF_FITNESS = "fitness."
#: Column heads of ``Group.answers`` in tables.
ANSWERS = ["usable", "pass [%]"]
Quartiles = tuple[float, float, float]


class Group(NamedTuple):
    """Runs with the same settings and different seeds."""

    number: int  # from 1; its name in tables and pictures
    task: str  # scenario and settings of the fitness; scores are comparable only within a task
    measure: str  # compared number: title of the merit of all runs of the task, or fitness
    settings: dict[str, str]  # only settings in which groups differ
    runs: list[Run]
    finished: list[Run]  # one run per seed, as another run with the same seed adds nothing
    scores: Floats  # (finished,) value of ``key``, in float64; -inf where a design diverged
    quartiles: Quartiles  # of the scores; nan without a finished run

    def __repr__(self) -> str:
        shown = {"label": self.label, "task": self.task, "measure": self.measure}
        return line("Group", {**shown, "median": self.median, "finished": len(self.finished)})

    @property
    def key(self) -> str:
        """Key, in ``Run.score``, of the number that is compared."""
        return FITNESS if self.measure == FITNESS else MERIT

    @property
    def median(self) -> float:
        """Median of the final score."""
        return self.quartiles[1]

    @property
    def broken(self) -> int:
        """Number of finished runs in which no design that was tried meets every constraint."""
        return sum(bool(run.score.get(LEAST_VIOLATED)) for run in self.finished)

    @property
    def with_history(self) -> list[Run]:
        """Runs whose convergence can be drawn: finished ones, or all if none has finished."""
        return [run for run in self.finished or self.runs if np.isfinite(run.best).any()]

    @property
    def answers(self) -> list[str]:
        """Seeds with a usable design, median share of machines that pass [%]; empty if unknown."""
        yes, _, share = self._usable
        count = sum(bool(run.use.verdict) for run in self.finished)
        return [f"{round(yes * count)} of {count}", f"{100 * share:.4g}"] if count else []

    @property
    def place(self) -> tuple[float, ...]:
        """Sort key of groups, the best first: shares of verdicts, share of machines, median."""
        return *(-x for x in self._usable), np.isnan(self.median), -self.median

    @property
    def _usable(self) -> tuple[float, ...]:
        """Shares of the two best verdicts, median share of machines that pass; 0 if unknown."""
        uses = [run.use for run in self.finished if run.use.verdict]
        best = (sum(use.verdict == x for use in uses) / max(len(uses), 1) for x in VERDICTS[:2])
        return *best, float(np.median([use.share or 0.0 for use in uses] or [0.0]))

    @property
    def row(self) -> list[str]:
        """Cells of a table: number of runs, median, quartiles, best."""
        count, total = len(self.finished), len(self.runs)
        runs = str(total) if count == total else f"{count} of {total}"
        if not count:
            return [runs, MISSING, MISSING, MISSING]
        low, median, high = map(score, self.quartiles)
        return [runs, median, f"{low} to {high}", score(self.scores.max())]

    def metrics(self) -> dict[str, Quartiles]:
        """Quartiles of each metric over the finished runs that have it."""
        values: dict[str, list[float]] = defaultdict(list)
        for run in self.finished:
            for key, value in run.score.items():
                if value is not None and key != LEAST_VIOLATED:
                    values[key].append(value)
        return {key: quartiles(np.array(column)) for key, column in values.items()}

    @property
    def label(self) -> str:
        """Number of the group, and its label or the settings that distinguish it in its task."""
        keys = (k for k in self.settings if k != SCENARIO and not k.startswith(OF_FITNESS))
        words = [f"{key.rpartition('.')[2]} {self.settings[key]}" for key in keys]
        if LABEL in self.settings:
            words = [self.settings[LABEL]]
        return f"{self.number}: {', '.join(words)}" if words else str(self.number)


def group_table(groups: Sequence[Group], names: Sequence[Sequence[str]], *head: str) -> Table:
    """Return a row for each group: ``names`` (one list each, under ``head``), scores, answers."""
    answers = ANSWERS if any(group.answers for group in groups) else []
    rows = [
        [*name, *group.row, *(answers and (group.answers or [MISSING] * len(answers)))]
        for name, group in zip(names, groups, strict=True)
    ]
    return Table("", [*head, "runs", "median", "quartiles", "best", *answers], rows)


def grouped(runs: Sequence[Run]) -> list[Group]:
    """Return the groups of the runs, task by task, the best first (see ``Group.place``)."""
    known = [run for run in runs if run.settings]
    keys = dict.fromkeys(key for run in known for key in run.settings if key != SEED)
    differing = [key for key in keys if len({run.setting(key) for run in known}) > 1]
    tasks: dict[str, dict[tuple[str, ...], list[Run]]] = {}
    for run in known:
        # A task is the scenario and the settings on which the fitness depends.
        fitness = [f"{key} {run.setting(key)}" for key in differing if key.startswith(OF_FITNESS)]
        members = tasks.setdefault(", ".join([run.setting(SCENARIO), *fitness]), {})
        members.setdefault(tuple(run.setting(key) for key in differing), []).append(run)
    groups: list[Group] = []
    for task, members in tasks.items():
        finished = [run for inside in members.values() for run in inside if run.state == "finished"]
        judge, *others = {run.judged_by for run in finished} or {FITNESS}
        # Runs of an earlier version do not name their merit.
        measure = FITNESS if others else judge or FITNESS
        named = ((dict(zip(differing, x, strict=True)), inside) for x, inside in members.items())
        result = [_group(task, measure, settings, inside) for settings, inside in named]
        groups += sorted(result, key=lambda group: group.place)
    return [group._replace(number=k) for k, group in enumerate(groups, 1)]


def _group(task: str, measure: str, settings: dict[str, str], runs: list[Run]) -> Group:
    finished: dict[str, Run] = {}
    for run in runs:
        if run.state == "finished":
            finished.setdefault(run.setting(SEED), run)
    group = Group(
        0, task, measure, settings, runs, [*finished.values()], np.empty(0), (np.nan,) * 3
    )
    values = [run.score.get(group.key) for run in group.finished]
    scores = np.array([-np.inf if value is None else value for value in values], float)
    return group._replace(scores=scores, quartiles=quartiles(scores))


def quartiles(values: Floats) -> Quartiles:
    """Return lower quartile, median and upper quartile, possibly -inf; nan without values."""
    if not len(values):
        return np.nan, np.nan, np.nan
    with np.errstate(invalid="ignore"):  # between -inf and a finite number
        quantiles = np.quantile(values, (0.25, 0.5, 0.75))
    low, median, high = np.nan_to_num(quantiles, nan=-np.inf, neginf=-np.inf).tolist()
    return low, median, high
