"""Where peers search: individuals as points in good coordinates, and where they begin."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from hfc_design.controllers.genome import Population, joined, taken
from hfc_design.core.numbers import Floats
from hfc_design.search.coordinates import coordinates

#: A coordinate without bounds, a logarithm, goes no further than this from where it began.
FAR = 3.0
#: First individuals, drawn and informed, of each structure of a C-axis.
FIRST = 4


class Chart(NamedTuple):
    """Points of one structure; 0 is where the search begins."""

    size: int
    step: float  # what the genome thinks of as a first standard deviation
    members: Callable[[Floats], Population]  # (n, size) -> individuals
    low: Floats  # (size,)
    high: Floats


def first(genome: Any, informed: bool, rng: np.random.Generator) -> Population:
    """First individuals on every structure: what is known of the machine, or random planes."""
    tree = np.tile(np.arange(genome.structures), 2 * FIRST)
    known = genome.informed(tree, rng) if informed else None
    if known is None:
        return genome.fresh(tree, rng)
    return joined(known, taken(genome.fresh(tree, rng), slice(genome.structures)))


def charts_about(genome: Any, population: Population, score: Floats, islands: int) -> list[Chart]:
    """About the best of each of the best structures."""
    order = np.argsort(-score, kind="stable")
    order = order[np.isfinite(score[order])]
    best = order[np.sort(np.unique(population.tree[order], return_index=True)[1])][:islands]
    return [chart_about(genome, taken(population, np.array([k]))) for k in best]


def chart_about(genome: Any, about: Population) -> Chart:
    """Of a population of one."""
    found = coordinates(genome, about)
    low, high = (np.clip(np.nan_to_num(x, nan=0.0), -FAR, FAR) for x in found.room)
    return Chart(found.size, found.step, found.members, low, high)


def charts_of_stage(
    genome: Any, number: int, about: Population | None, islands: int, rng: np.random.Generator
) -> list[Chart]:
    """Of a stage of a genome, on the structure that the last one ended with and on others."""
    stage = genome.stage(number, about)
    own = 0 if about is None else int(about.tree[0])
    others = rng.permutation(np.setdiff1d(np.arange(genome.structures), [own]))
    trees = [own, *others[: islands - 1].tolist()]
    far = np.full(len(stage.start), FAR)

    def chart(tree: int) -> Chart:
        def members(points: Floats) -> Population:
            return stage.members(stage.start + points, np.full(len(points), tree))

        return Chart(len(stage.start), stage.step, members, -far, far)

    return [chart(tree) for tree in trees]
