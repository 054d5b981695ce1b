"""What searches are worth in the end: in float64, with repeats or on machines nobody has seen."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import jax
import numpy as np

from experiments.search_power.lockstep import Seed
from experiments.search_power.tasks import Field
from hfc_design.controllers.genome import Population, joined, taken
from hfc_design.core.numbers import Floats
from hfc_design.runs.problem import final_problem
from hfc_design.simulation import population as simulate
from hfc_design.simulation.repeats import FACTORS, Repeats, ScaledCommand

#: Finalists of a seed that are repeated: the best of all of them in float64.
REPEATED = 4
#: Machines on which incumbents are compared, the best of them that are compared on as many as a
#: design run ends with, and the seeds of the machines that no search has.
COMPARED, LIKELY, UNSEEN, OTHERS = 128, 4, 1_000_001, 1_000_002
#: Individuals that are simulated at once on many machines, on one with repeats.
AT_ONCE, REPEATED_AT_ONCE = 24, 128


class Final(NamedTuple):
    """Of the seeds of a method."""

    final: Floats  # (seeds,)
    #: (seeds, checks) what they would have been worth on the way; None: as they were told.
    way: Floats | None
    trees: list[int]


def finals(field: Field, seeds: Sequence[Seed]) -> Final:
    """What the best finalist of every seed is worth."""
    return _single(field, seeds) if field.single else _robust(field, seeds)


def _single(field: Field, seeds: Sequence[Seed]) -> Final:
    """The best worth: the merit in float64, of a chaotic loop the lowest of its repeats."""
    populations = [one.incumbents[-1] for one in seeds]
    rank = _split(_ranked(field, joined(*populations)), populations)
    chosen = [
        taken(own, np.argsort(-worth, kind="stable")[:REPEATED])
        for own, worth in zip(populations, rank, strict=True)
    ]
    worth = _split(_repeated(field, joined(*chosen)), chosen)
    best = [int(np.argmax(own)) for own in worth]
    final = np.array([own[k] for own, k in zip(worth, best, strict=True)])
    trees = [int(own.tree[k]) for own, k in zip(chosen, best, strict=True)]
    return Final(final, None, trees)


def _ranked(field: Field, population: Population) -> Floats:
    loop, machines, motions = field.problem.loop, field.problem.machines, field.problem.motions
    gains = field.problem.genome.gains(_filled(population))
    judged = simulate.scores(loop, machines, motions, gains, np.float64)
    return judged.rank[: len(population.tree), 0, 0]


def _repeated(field: Field, population: Population) -> Floats:
    """(n,) what each is worth."""
    loop, machines, motions = field.problem.loop, field.problem.machines, field.problem.motions
    louder = loop._replace(controller=ScaledCommand(loop.controller))
    found = []
    at_once = min(REPEATED_AT_ONCE, _power_of_two(len(population.tree)))
    for start in range(0, len(population.tree), at_once):
        own = taken(population, slice(start, start + at_once))
        gains = field.problem.genome.gains(_filled(own, at_once))
        wide: Any = jax.tree.map(lambda leaf: np.repeat(leaf, len(FACTORS), axis=-1), gains)
        factors = np.tile(FACTORS, at_once)
        judged = simulate.scores(louder, machines, motions, (factors, wide), np.float64)
        values = judged.rank[:, 0, 0].reshape(-1, len(FACTORS))[: len(own.tree)]
        found += [Repeats(x).worth for x in values]
    return np.array(found)


def _filled(population: Population, width: int = 0) -> Population:
    """With copies of the last one, so that few programs are compiled."""
    count = len(population.tree)
    width = width or -(-count // 128) * 128
    return taken(population, np.minimum(np.arange(width), count - 1))


def _power_of_two(count: int) -> int:
    return 1 << (count - 1).bit_length()


def _robust(field: Field, seeds: Sequence[Seed]) -> Final:
    """The incumbent that is best on unseen machines, as many as a design run ends with, on others.

    As a design run chooses: who may be the best on a quarter of them, and these on all.
    """
    firsts = [joined(*(taken(x, slice(1)) for x in one.incumbents)) for one in seeds]
    machines = np.arange(COMPARED)
    way = _on_machines(field, joined(*firsts), UNSEEN, machines).reshape(len(seeds), -1)
    robust = field.scenario.robust
    assert robust is not None
    many, likely = np.arange(robust.final), np.argsort(-way, axis=1, kind="stable")[:, :LIKELY]
    few = [taken(own, k) for own, k in zip(firsts, likely, strict=True)]
    best = _on_machines(field, joined(*few), UNSEEN, many).reshape(likely.shape).argmax(axis=1)
    chosen = [taken(own, np.array([k])) for own, k in zip(few, best, strict=True)]
    final = _on_machines(field, joined(*chosen), OTHERS, many)
    way = np.maximum.accumulate(way, axis=1)
    return Final(final, way, [int(one.tree[0]) for one in chosen])


def _on_machines(field: Field, population: Population, seed: int, machines: Any) -> Floats:
    run = field.scenario.run.model_copy(update={"seed": seed})
    problem = final_problem(field.scenario.model_copy(update={"run": run}))
    found = []
    at_once = max(AT_ONCE * COMPARED // len(machines), 1)
    at_once = min(at_once, _power_of_two(len(population.tree)))
    for start in range(0, len(population.tree), at_once):
        own = taken(population, slice(start, start + at_once))
        found.append(problem.rank_on(_filled(own, at_once), machines)[: len(own.tree)])
    return np.concatenate(found)


def _split(values: Floats, populations: Sequence[Population]) -> list[Floats]:
    return np.split(values, np.cumsum([len(own.tree) for own in populations])[:-1])
