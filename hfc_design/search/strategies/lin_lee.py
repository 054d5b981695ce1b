"""The two-phase genetic algorithm of Lin & Lee 1999, section 3.2, as published."""

from collections.abc import Callable, Iterable
from functools import cache, partial
from typing import Literal, NamedTuple, cast

import numpy as np
from pydantic import Field

from hfc_design.controllers.genome import joined, taken
from hfc_design.controllers.hierarchical import tree as hierarchy
from hfc_design.controllers.hierarchical.genome import HierarchicalGenome, Hierarchies
from hfc_design.controllers.kind import ControllerSettings
from hfc_design.controllers.linear.record import Range
from hfc_design.core.numbers import Floats, Integers, Mask
from hfc_design.core.records import NotNegative, Positive
from hfc_design.search.strategy import Probability, Strategy, StrategySettings, Task


class LinLeeSettings(StrategySettings):
    """The two-phase genetic algorithm of Lin & Lee 1999, section 3.2, with their numbers."""

    preset: Literal["lin-lee-1999"] = "lin-lee-1999"
    #: n, individuals in a generation; the three thirds are rounded
    population: int = Field(30, ge=3, le=10_000_000)
    generations: int = Field(200, ge=1, le=10_000_000)
    structure_crossover: Probability = 0.3  # p_c1, its probability [1]
    structure_mutation: Probability = 0.5  # alpha, its probability per bit [1]
    parameter_crossover: Probability = 0.7  # p_c2, its probability [1]
    parameter_mutation: Probability = 0.8  # beta, its probability per number [1]
    gain_step: Positive = 10.0  # A_max of the PD gains [command/error, command s/error]
    centre_step: Positive = 0.1  # A_max of the consequent centres [1]
    kp_range: Range = (10.0, 1_500.0)  # range of new individuals [command/error]
    kd_range: Range = (10.0, 1_500.0)  # range of new individuals [command s/error]
    #: weight of the share of time that it sticks [1]; the paper has none
    stick_penalty: NotNegative = 0.0
    level_limit: Positive = 2.0  # |common level| of the consequents of a new individual [1]


class LinLeeState(NamedTuple):
    """A generation, the best individual first."""

    genes: Integers  # (n, inputs) number of the unit, in heap order, that each input enters
    population: Hierarchies
    score: Floats  # (n,)


class Asked(NamedTuple):
    """The next generation, and the genes from which it was decoded."""

    genes: Integers
    population: Hierarchies


class LinLee(NamedTuple):
    """The paper's algorithm.

    Assumptions where the paper is silent: each number mutates with probability beta by
    ``(2 r - 1) A_max`` with r uniform in (0, 1); fresh consequents are a common level plus a spread
    of at most the centre step, which matches the printed tables.
    """

    settings: LinLeeSettings
    task: Task

    @property
    def _genome(self) -> HierarchicalGenome:
        return cast(HierarchicalGenome, self.task.genome)  # see ``_fault``

    def start(self, rng: np.random.Generator) -> tuple[None, Asked]:
        """Return n random valid individuals (steps 2 and 3)."""
        inputs = len(self._genome.scales)
        units = hierarchy.unit_count(inputs)
        genes = _valid(lambda: [rng.integers(units, size=inputs)], self.settings.population)
        return None, Asked(genes, self._fresh(genes, rng))

    def ask(
        self, state: LinLeeState, generation: int, rng: np.random.Generator
    ) -> tuple[LinLeeState, Asked]:
        """Return a third each of elite, crossed and mutated individuals (step 5)."""
        count = len(state.score)
        third = max(count // 3, 1)
        elite = Asked(state.genes[:third], taken(state.population, slice(third)))
        crossed = self._crossed(state, third, rng)
        mutated = self._mutated(state, count - 2 * third, rng)
        parts = (elite, crossed, mutated)
        genes = np.concatenate([part.genes for part in parts])
        return state, Asked(genes, joined(*(part.population for part in parts)))

    def tell(self, state: LinLeeState | None, candidates: Asked, score: Floats) -> LinLeeState:
        """Replace the old population by the new one (step 6)."""
        order = np.argsort(-score, kind="stable")
        return LinLeeState(
            candidates.genes[order], taken(candidates.population, order), score[order]
        )

    def _fresh(self, genes: Integers, rng: np.random.Generator) -> Hierarchies:
        s, genome = self.settings, self._genome
        count, inputs = genes.shape
        units = inputs - 1
        level = rng.uniform(-s.level_limit, s.level_limit, (count, units, 1, 1))
        spread = rng.uniform(-s.centre_step, s.centre_step, (count, units, 7, 7))
        low, high = np.array([s.kp_range, s.kd_range]).T
        return genome.empty()._replace(
            tree=_trees(genes),
            gains=rng.uniform(low, high, (count, 2)),
            scales=np.tile(genome.scales, (count, 1)),
            consequents=level + spread,
        )

    def _crossed(self, state: LinLeeState, count: int, rng: np.random.Generator) -> Asked:
        """Return children: structure bits by two-point crossover, numbers averaged (step 5b)."""
        genes = _valid(lambda: self._crossed_genes(state, rng), count)
        children = self._fresh(genes, rng)
        gains, consequents = children.gains.copy(), children.consequents.copy()
        sources = state.population.gains, state.population.consequents
        waiting: dict[int, int] = {}
        for k, tree in enumerate(children.tree.tolist()):
            partner = waiting.pop(tree, None)
            if partner is None:
                waiting[tree] = k
                continue
            parents = np.flatnonzero(state.population.tree == tree)
            if len(parents) < 2 or rng.random() >= self.settings.parameter_crossover:
                continue
            a, b = rng.choice(parents, 2, replace=False)
            share = rng.random()
            for child, w in ((partner, share), (k, 1.0 - share)):
                for array, source in zip((gains, consequents), sources, strict=True):
                    array[child] = w * source[a] + (1.0 - w) * source[b]
        return Asked(genes, children._replace(gains=gains, consequents=consequents))

    def _crossed_genes(self, state: LinLeeState, rng: np.random.Generator) -> Integers:
        """Return the genes of two random parents, crossed with probability p_c1, valid or not."""
        pair = _bits(state.genes[rng.choice(len(state.genes), 2, replace=False)])
        # With two inputs there is one structure, and no bits.
        if rng.random() < self.settings.structure_crossover and pair.size:
            one, two = np.sort(rng.choice(pair.shape[1] + 1, 2, replace=False))
            pair = two_point(pair, int(one), int(two))
        return _genes(pair, state.genes.shape[1])

    def _mutated(self, state: LinLeeState, count: int, rng: np.random.Generator) -> Asked:
        """Return random parents with flipped structure bits and changed numbers (step 5c)."""
        s = self.settings
        chosen = rng.choice(len(state.genes), count, replace=False)
        bits, share = _bits(state.genes[chosen]), s.structure_mutation

        def flipped(row: Mask) -> Integers:
            return _genes((row ^ (rng.random(row.shape) < share))[None], state.genes.shape[1])

        genes = np.concatenate([_valid(partial(flipped, row), 1) for row in bits])
        parents = taken(state.population, chosen)

        def moved(array: Floats, largest: float) -> Floats:
            change = rng.uniform(-largest, largest, array.shape)
            return array + change * (rng.random(array.shape) < s.parameter_mutation)

        children = parents._replace(
            tree=_trees(genes),
            gains=moved(parents.gains, s.gain_step),
            consequents=moved(parents.consequents, s.centre_step),
        )
        return Asked(genes, children)


def two_point(pair: Mask, first: int, behind: int) -> Mask:
    """Return two bit strings (2, bits) with the places ``first`` to ``behind - 1`` exchanged."""
    crossed = pair.copy()
    crossed[:, first:behind] = pair[::-1, first:behind]
    return crossed


@cache
def _tree_index(gene: tuple[int, ...]) -> int | None:
    """Return the index in ``hierarchy.trees`` that a gene decodes to; None if it is invalid."""
    tree = hierarchy.decode(gene)
    return None if tree is None else hierarchy.trees(len(gene)).index(tree)


def _valid(draw: Callable[[], Iterable[Integers]], count: int) -> Integers:
    """Draw genes until ``count`` of them decode to a hierarchy; return these."""
    genes: list[Integers] = []
    while len(genes) < count:
        genes += [gene for gene in draw() if _tree_index(tuple(gene.tolist())) is not None]
    return np.array(genes[:count])


def _trees(genes: Integers) -> Integers:
    return np.array([_tree_index(tuple(gene)) for gene in genes.tolist()])


def _bits(genes: Integers) -> Mask:
    """Return the bits of the genes, most significant first, (n, inputs (inputs - 2))."""
    width = genes.shape[1] - 2
    places = np.arange(width - 1, -1, -1)
    return ((genes[:, :, None] >> places) & 1).reshape(len(genes), -1).astype(bool)


def _genes(bits: Mask, inputs: int) -> Integers:
    width = inputs - 2
    places = 2 ** np.arange(width - 1, -1, -1)
    return np.asarray((bits.reshape(len(bits), inputs, width) * places).sum(axis=2))


def _fault(settings: LinLeeSettings, controller: ControllerSettings) -> str | None:
    if controller.kind != "pd+hierarchical-fuzzy":
        return "searches only hierarchies; use race"
    if getattr(controller, "linear", None) is not None:
        return "searches only hierarchies with a PD; use cma or race"
    if getattr(controller, "used", 0):
        return "searches only hierarchies of all inputs; use race"
    return None


def _sound(settings: LinLeeSettings, state: LinLeeState) -> bool:
    return (
        state.genes.shape == (settings.population, state.population.scales.shape[1])
        and np.array_equal(_trees(state.genes), state.population.tree)
        and state.score.shape == (settings.population,)
        and bool((state.score < np.inf).all())
        and bool((state.score[:-1] >= state.score[1:]).all())
    )


STRATEGY = Strategy(
    "lin-lee-1999",
    LinLeeSettings,
    LinLeeState,
    LinLee,
    "the two-phase genetic algorithm of Lin & Lee (1999), of hierarchies",
    _fault,
    _sound,
)
