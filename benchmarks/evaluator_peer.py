"""The population evaluator, and the work made with its package."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from work import Constants, Machine, Work

from hfc_design.controllers.controller import PerAxis
from hfc_design.controllers.hierarchical import tree as hierarchy
from hfc_design.controllers.hierarchical.law import HierarchicalGains, hierarchical
from hfc_design.controllers.hierarchical.record import layout_of
from hfc_design.files.loop_setup import controller_of, load_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.scenario import Scenario
from hfc_design.simulation import population as simulate
from hfc_design.simulation.closed_loop import closed_loop
from hfc_design.simulation.machines import drawn
from plants.c_axis import CAxisParameters, coefficients

TOLERANCE = 0.2  # of every parameter of a machine
DISTINCT = 4096  # individuals of a large population
SPREAD = 0.1  # of the consequents inside every published rule table


def prepare(work: Work, dtype: Any = np.float32) -> Callable[[], np.ndarray]:
    """A function that scores all individuals, (individuals,), as a search calls it."""
    run = on_machines(work, 1, dtype)
    return lambda: run().merit[:, 0, 0]


def on_machines(work: Work, count: int, dtype: Any = np.float32) -> Callable[[], simulate.Judged]:
    """A function that scores all individuals on the machine and others within 20 % of it."""
    scenario = _scenario(work.reference.size)
    law = hierarchical(layout_of(scenario.controller), scenario.simulation.sample_time_s)
    loop = closed_loop(scenario, PerAxis(scenario.controller.kind, (law,)))
    machines, samples = drawn(scenario.plant, TOLERANCE, count - 1, 0)[0], [scenario.samples()]
    gains = HierarchicalGains(work.kp, work.kd, work.scales, work.sources, work.consequents)
    run = partial(simulate.scores, loop, machines, samples, gains, dtype)
    run()  # compiles
    return run


def make(individuals: int, samples: int, seed: int = 0) -> Work:
    """Random individuals around Table I of Lin & Lee 1999, each with a tree of its own."""
    generator = np.random.default_rng(seed)
    scenario = _scenario(samples)
    _, published = controller_of(load_design("lin-lee-1999-table-1"), scenario)
    trees = hierarchy.all_sources(5)
    chosen = trees[generator.integers(len(trees), size=individuals)]
    spread = generator.uniform(-SPREAD, SPREAD, (*published.consequents.shape[:-1], individuals))
    gain = generator.uniform(0.9, 1.1, (2, individuals))
    happens, fitness = scenario.samples(), scenario.fitness
    (axis,) = happens.axes
    (machine,) = scenario.plant.values()
    layout = layout_of(scenario.controller)
    terms = np.array([term[1:] for term in layout.terms]).T
    constants = Constants(
        happens.sample_time, layout.output_scale, fitness.error, fitness.error_rate
    )
    return Work(
        _float32(published.kp * gain[0]),
        _float32(published.kd * gain[1]),
        _float32(np.repeat(published.scales, individuals, axis=-1)),
        np.ascontiguousarray(np.moveaxis(chosen, 0, -1), np.int32),
        _float32(published.consequents + spread),
        *map(_float32, (axis.reference, axis.reference_rate, axis.loads)),
        *map(_float32, (terms, _machine(machine), constants)),
    )


def stable(individuals: int, samples: int) -> tuple[Work, np.ndarray]:
    """Individuals and their scores in float64: the better half of twice as many.

    One that runs away multiplies its rounding errors from sample to sample, in every contender
    differently.
    """
    everyone = make(2 * individuals, samples)
    exact = prepare(everyone, np.float64)()
    best = np.argsort(exact)[-individuals:]
    return pick(everyone, best), exact[best]


def many(individuals: int, samples: int) -> Work:
    """As ``make``, of which the first few thousand are random and the others repeat them."""
    work = make(min(individuals, DISTINCT), samples)
    return pick(work, np.arange(individuals) % work.kp.size)


def pick(work: Work, individuals: np.ndarray) -> Work:
    """``work`` for a selection of its individuals."""
    return Work(*(np.ascontiguousarray(leaf[..., individuals]) for leaf in work[:5]), *work[5:])


def _scenario(samples: int) -> Scenario:
    return load_scenario(
        "c-axis-ramp", [f"simulation.duration_s={samples / 1000}", "search.stick_penalty=0"]
    )


def _float32(values: Any) -> np.ndarray:
    return np.ascontiguousarray(values, np.float32)


def _machine(p: CAxisParameters) -> Machine:
    found = coefficients(p)._asdict() | coefficients(p).friction._asdict()
    named = {"viscous_friction": "viscous", "coulomb_torque": "coulomb"}
    return Machine(*(found[named.get(field, field)] for field in Machine._fields))
