"""Many designs, each judged in every scenario on every machine.

Designs of the same kind, terms and limits are simulated together, by one program for each scenario.
"""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Literal, NamedTuple

import jax
import numpy as np

from hfc_design.controllers.controller import Controller
from hfc_design.core.arguments import check_number, check_type
from hfc_design.core.numbers import Floats, Gains, Integers, Mask
from hfc_design.core.records import UserError, checked
from hfc_design.files.design import AnyDesign
from hfc_design.files.loop_setup import controller_of, load_design, machine, with_converter
from hfc_design.files.machine import PlantSettings
from hfc_design.files.named_scenario import AnyScenario, load_scenario
from hfc_design.files.scenario import Scenario
from hfc_design.objectives.judge import Judged
from hfc_design.simulation import population
from hfc_design.simulation.closed_loop import closed_loop
from hfc_design.simulation.divergence import refined
from hfc_design.simulation.population import Machines
from hfc_design.simulation.stepping import trailing


class Judgements(NamedTuple):
    """Merits, fitness values and failures of designs, (designs, scenarios, machines) each."""

    merit: Floats  # -inf where the loop failed
    fitness: Floats  # -inf where the loop failed
    failed: Mask

    def kept(self, how: Literal["mean", "quantile", "worst"], share: float = 0.05) -> Floats:
        """Return one merit for each design, (designs,), from those in all scenarios and machines.

        ``how`` selects the mean, the quantile of ``share`` (not interpolated) or the lowest merit.
        A design that fails anywhere has the mean -inf.

        Raises:
            UserError: ``how`` is none of these, or ``share`` is not between 0 and 1.
        """
        check_number("share", share)
        if not 0 <= share <= 1:
            raise UserError(f"share = {share}: must be between 0 and 1")
        quantile = partial(np.quantile, q=share, method="lower")
        ways: dict[str, Any] = {"mean": np.mean, "quantile": quantile, "worst": np.min}
        if how not in ways:
            raise UserError(f"how={how!r}: must be one of {', '.join(ways)}")
        return np.asarray(ways[how](self.merit.reshape(len(self.merit), -1), axis=1))


def evaluate_many(
    designs: AnyDesign | Sequence[AnyDesign],
    scenarios: AnyScenario | Sequence[AnyScenario],
    machines: Mapping[str, float] | Sequence[Mapping[str, float]] = ({},),
) -> Judgements:
    """Return the judgements of designs in every scenario on every machine, in float64.

    Each of ``machines`` has the parameters that differ from those of the design's machine: of all
    axes, or of one as in ``"x.gain"``. A single design, scenario or machine needs no list.

    Raises:
        UserError: a design does not fit a scenario, or a machine cannot exist.
    """
    every, where = [*map(load_design, _each(designs))], [*map(load_scenario, _each(scenarios))]
    others = _each(machines)
    if not (every and where and others):
        raise UserError("designs, scenarios and machines: must have at least one each")
    shape = (len(every), len(where), len(others))
    judgements = Judgements(np.empty(shape), np.empty(shape), np.empty(shape, bool))
    for j, scenario in enumerate(where):
        # Designs with the same program and the same machines can be simulated together.
        alike = defaultdict(list)
        for k, design in enumerate(every):
            plant = machine(design, scenario)
            plants = tuple(_changed(plant, changes).values() for changes in others)
            controller, gains = controller_of(design, scenario)
            limits = with_converter(scenario, design).limits
            alike[controller, plant.values(), plants, limits.model_dump_json()].append((k, gains))
        for (controller, nominal, plants, _), members in alike.items():
            places = [k for k, _ in members]
            each = (gains for _, gains in members)
            together = jax.tree.map(lambda *leaves: np.concatenate(leaves, axis=-1), *each)
            true = jax.tree.map(lambda *numbers: np.array(numbers, np.float64), *plants)
            paired = with_converter(scenario, every[places[0]])
            judged = _judged(paired, controller, Machines(nominal, true), together)
            fitness = np.where(judged.failed, -np.inf, judged.values[..., 0])
            judgements.failed[places, j] = judged.failed[..., 0]
            judgements.merit[places, j] = judged.rank[..., 0]
            judgements.fitness[places, j] = fitness[..., 0]
    return judgements


def _judged(scenario: Scenario, controller: Controller, machines: Machines, gains: Gains) -> Judged:
    """Return the judge's results; individuals that fail anywhere are repeated in finer steps."""

    def simulate(where: Scenario, chosen: Integers) -> list[Judged]:
        some = jax.tree.map(lambda leaf: leaf[..., chosen], gains)
        loop = closed_loop(where, controller)
        return population.scores(loop, machines, [where.samples()], some, np.float64).rows

    def merged(before: Judged, after: Judged) -> Judged:
        """Return the repetition where only the first result has failed, else the first result."""
        mended = before.failed & ~after.failed
        merit = np.where(mended, after.merit, before.merit)
        values = np.where(mended[..., None], after.values, before.values)
        return Judged(merit, values, before.failed & after.failed)

    about = (scenario, trailing(gains), simulate)
    return Judged.stacked(refined(*about, lambda row: bool(row.failed.any()), merged))


def _each(given: Any) -> Sequence[Any]:
    """Return a sequence as it is; a text, or anything else, becomes a list of one."""
    return given if isinstance(given, Sequence) and not isinstance(given, str) else [given]


def _changed(plant: PlantSettings, changes: Mapping[str, float]) -> PlantSettings:
    """Return the settings of a machine with changed parameters; ``x.NAME`` changes only axis x."""
    check_type(changes, Mapping, "a mapping of parameters to values, as in {'gain': 28.3}")
    every = {key: value for key, value in changes.items() if "." not in key}
    axes = {axis: numbers | every for axis, numbers in plant.axes.items()}
    for key in changes.keys() - every.keys():
        axis, _, name = key.partition(".")
        axes.setdefault(axis, {})[name] = changes[key]
    data = {"name": plant.name, "parameters": plant.parameters | every, "axes": axes}
    return checked(PlantSettings, data, "machines", Path())
