"""The front of a run: costs of its points, its file, and the selection of a point."""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hfc_design.controllers.genome import Population, taken
from hfc_design.core.checkpoint import write_whole
from hfc_design.core.numbers import Floats, Integers, number_of
from hfc_design.core.records import RunError, UserError, option
from hfc_design.core.wording import one_of
from hfc_design.files.scenario import Scenario
from hfc_design.objectives.metric import in_units
from hfc_design.objectives.traded import Traded
from hfc_design.runs.problem import final_problem
from hfc_design.search.fronts import dominated, knee, scaled
from hfc_design.search.loop import Search
from hfc_design.simulation.acceptance import ENOUGH
from plants import in_a_name

FRONT = "front.csv"


class Front(NamedTuple):
    """Points that no other point dominates, sorted by first cost; all meet every constraint."""

    objectives: tuple[Traded, ...]
    costs: Floats  # (points, objectives)
    merit: Floats  # (points,) merit by which the scenario ranks designs
    places: Integers  # (points,) indices of the individuals in the front of the search

    @property
    def best(self) -> int:
        """Index of the point of ``design.json``: the one with the largest merit."""
        return int(np.argmax(self.merit))

    @property
    def knee(self) -> int:
        """Index of the knee, beyond which a small gain in one cost is a large loss in another."""
        return knee(self.costs)

    def individual(self, search: Search, point: int) -> Population:
        """Return a point, counted from 0, as a population of one."""
        return taken(search.state.front.population, self.places[point : point + 1])


def front_of(search: Search, scenario: Scenario) -> Front | None:
    """Return the front of a search, with its points evaluated again as in the final choice.

    None if the strategy has no trade-off. Few machines overrate points: a point that violates
    constraints on more machines than a usable design may, or that is now dominated, is removed; the
    front may then be empty.
    """
    objectives = scenario.traded
    if not objectives:
        return None
    population = search.state.front.population
    count = len(population.tree)
    if not count:
        return Front(objectives, np.empty((0, len(objectives))), np.empty(0), np.arange(0))
    if scenario.robust:  # at least as many machines may fail as *Can I use it?* allows
        most = max(scenario.robust.forgiven, 1.0 - ENOUGH)
        robust = scenario.robust.model_copy(update={"forgiven": most})
        scenario = scenario.model_copy(update={"robust": robust})
    weighed = final_problem(scenario).weighed(population)
    left = np.flatnonzero(weighed.violation == 0.0)
    left = left[~dominated(weighed.costs[left], weighed.costs[left])]
    left = left[np.lexsort(weighed.costs[left].T[::-1])]
    return Front(objectives, weighed.costs[left], weighed.score[left], left)


def _heads(objectives: tuple[Traded, ...]) -> list[str]:
    columns = (f"{x.name}_{in_a_name(x.unit)}" if x.unit != "1" else x.name for x in objectives)
    return ["point", *columns, "merit", "mark", "individual"]


def marks(front: Front) -> list[str]:
    """Return the mark of each point: "knee", "design", both, or ""."""
    marked = [(front.knee, "knee"), (front.best, "design")] if len(front.merit) else []
    points = range(len(front.merit))
    return [" ".join(text for place, text in marked if place == k) for k in points]


def write_front(front: Front, folder: Path) -> None:
    """Write ``front.csv``; RunError: it cannot be written."""
    lines = [",".join(_heads(front.objectives))]
    rows = zip(front.costs.tolist(), front.merit.tolist(), marks(front), front.places, strict=True)
    for k, (costs, merit, mark, place) in enumerate(rows, 1):
        lines.append(",".join([str(k), *map(repr, (*costs, merit)), mark, str(place)]))
    write_whole(folder / FRONT, ("\n".join(lines) + "\n").encode())


def read_front(scenario: Scenario, search: Search | None, folder: Path) -> Front | None:
    """Return the front of a finished run, or None; RunError: its file is missing or damaged."""
    objectives, path = scenario.traded, folder / FRONT
    if not objectives or search is None:
        return None
    try:
        head, *lines = path.read_text(encoding="utf-8").splitlines()
        rows = [line.split(",") for line in lines]
        numbers = np.array([[number_of(x) for x in (*row[1:-2], row[-1])] for row in rows])
        numbers = numbers.reshape(len(rows), len(objectives) + 2)
        places = numbers[:, -1].astype(np.int64)
        if head != ",".join(_heads(objectives)) or not np.isfinite(numbers).all():
            raise ValueError("is not a file of such a run")
        if not np.isin(places, np.arange(len(search.state.front.population.tree))).all():
            raise ValueError("names individuals that the search does not have")
    except (OSError, ValueError) as error:
        raise RunError(f"{path}: is missing or damaged ({error})") from None
    return Front(objectives, numbers[:, :-2], numbers[:, -2], places)


def chosen(
    front: Front, scenario: Scenario, point: int | None, wanted: Mapping[str, float | str] | None
) -> int:
    """Return the index of a point: number ``point`` (from 1), nearest to ``wanted``, or the knee.

    The distance to ``wanted`` costs is measured in shares of the front's width.

    Raises:
        UserError: there is no such point, or a cost is not one of the front's or has another unit.
    """
    size = len(front.merit)
    if point is not None:
        if not 1 <= point <= size:
            raise UserError(f"{option('point', point)}: must be 1 to {size}")
        return point - 1
    if wanted is None:
        return front.knee
    names = [one.name for one in front.objectives]
    low, width = front.costs.min(axis=0), np.ptp(front.costs, axis=0)
    away = np.zeros(size)
    for name, text in wanted.items():
        given = option("nearest", key=name)
        if name not in names:
            raise UserError(f"{given}: unknown objective here; {one_of(name, names)}")
        k = names.index(name)
        try:
            value = in_units(given, text, front.objectives[k].unit, scenario.units)
        except ValueError as error:
            raise UserError(str(error)) from None
        away += np.square((scaled(front.costs)[:, k]) - (value - low[k]) / (width[k] or 1.0))
    return int(np.argmin(np.round(away, 9)))  # of equally near points the first
