"""The two-phase genetic algorithm of Lin & Lee 1999, section 3.2, as they describe it."""

from functools import cache
from typing import NamedTuple

import numpy as np

from hfc_design.controllers.genome import Floats, Integers, Mask, joined
from hfc_design.controllers.hierarchical import tree as hierarchy
from hfc_design.controllers.hierarchical.genome import Hierarchies
from hfc_design.controllers.hierarchical.law import Layout
from hfc_design.search.settings import LinLeeSettings


class LinLeeState(NamedTuple):
    """A generation, the best individual first."""

    genes: Integers  # (n, inputs) heap unit that each input enters
    population: Hierarchies
    score: Floats  # (n,)


class Asked(NamedTuple):
    """The next generation and the genes it was decoded from."""

    genes: Integers
    population: Hierarchies


class LinLee(NamedTuple):
    """Ask and tell of the paper's algorithm.

    Where the paper is silent: each number mutates with probability beta by
    ``(2 r - 1) A_max`` with r uniform in (0, 1); fresh consequents are a common level plus a
    spread of at most the centre step, which is what the printed tables look like.
    """

    settings: LinLeeSettings
    layout: Layout
    scales: tuple[float, ...]

    def start(self, rng: np.random.Generator) -> tuple[None, Asked]:
        """n random valid individuals (steps 2 and 3)."""
        genes = np.array([self._random_gene(rng) for _ in range(self.settings.population)])
        return None, Asked(genes, self._fresh(genes, rng))

    def ask(
        self, state: LinLeeState, generation: int, newton: object, rng: np.random.Generator
    ) -> tuple[LinLeeState, Asked]:
        """Elite, crossed and mutated thirds (step 5)."""
        count = len(state.score)
        third = max(count // 3, 1)
        elite = Asked(state.genes[:third], state.population.take(slice(third)))
        crossed = self._crossed(state, third, rng)
        mutated = self._mutated(state, count - 2 * third, rng)
        parts = (elite, crossed, mutated)
        genes = np.concatenate([part.genes for part in parts])
        return state, Asked(genes, joined(*(part.population for part in parts)))

    def tell(self, state: LinLeeState | None, asked: Asked, score: Floats) -> LinLeeState:
        """The new population replaces the old one (step 6)."""
        order = np.argsort(-score, kind="stable")
        return LinLeeState(asked.genes[order], asked.population.take(order), score[order])

    def _random_gene(self, rng: np.random.Generator) -> Integers:
        inputs = len(self.layout.inputs)
        while True:
            gene = rng.integers(hierarchy.unit_count(inputs), size=inputs)
            if _tree_index(tuple(gene.tolist())) is not None:
                return gene

    def _fresh(self, genes: Integers, rng: np.random.Generator) -> Hierarchies:
        s = self.settings
        count, inputs = genes.shape
        units = inputs - 1
        level = rng.uniform(-s.level_limit, s.level_limit, (count, units, 1, 1))
        spread = rng.uniform(-s.centre_step, s.centre_step, (count, units, 7, 7))
        low, high = np.array([s.kp_range, s.kd_range]).T
        return Hierarchies(
            np.array([_tree_index(tuple(gene)) for gene in genes.tolist()]),
            rng.uniform(low, high, (count, 2)),
            np.tile(self.scales, (count, 1)),
            level + spread,
        )

    def _crossed(self, state: LinLeeState, count: int, rng: np.random.Generator) -> Asked:
        """Two-point crossover of the structure bits, weighted average of the rest (step 5b)."""
        genes = self._crossed_genes(state, count, rng)
        children = self._fresh(genes, rng)
        gains, consequents = children.gains.copy(), children.consequents.copy()
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
                for array, source in (
                    (gains, state.population.gains),
                    (consequents, state.population.consequents),
                ):
                    array[child] = w * source[a] + (1.0 - w) * source[b]
        return Asked(genes, children._replace(gains=gains, consequents=consequents))

    def _crossed_genes(self, state: LinLeeState, count: int, rng: np.random.Generator) -> Integers:
        """Valid structures from pairs of parents, crossed with probability p_c1."""
        found: list[Integers] = []
        while len(found) < count:
            pair = _bits(state.genes[rng.choice(len(state.genes), 2, replace=False)])
            if rng.random() < self.settings.structure_crossover:
                one, two = np.sort(rng.choice(pair.shape[1] + 1, 2, replace=False))
                pair = two_point(pair, int(one), int(two))
            for gene in _genes(pair, len(self.layout.inputs)):
                if _tree_index(tuple(gene.tolist())) is not None:
                    found.append(gene)
        return np.array(found[:count])

    def _mutated(self, state: LinLeeState, count: int, rng: np.random.Generator) -> Asked:
        """Random parents with flipped structure bits and moved numbers (step 5c)."""
        s = self.settings
        chosen = rng.choice(len(state.genes), count, replace=False)
        genes = np.array([self._mutated_gene(state.genes[k], rng) for k in chosen])
        parents = state.population.take(chosen)

        def moved(array: Floats, largest: float) -> Floats:
            change = rng.uniform(-largest, largest, array.shape)
            return array + change * (rng.random(array.shape) < s.parameter_mutation)

        return Asked(
            genes,
            parents._replace(
                tree=np.array([_tree_index(tuple(gene)) for gene in genes.tolist()]),
                gains=moved(parents.gains, s.gain_step),
                consequents=moved(parents.consequents, s.centre_step),
            ),
        )

    def _mutated_gene(self, gene: Integers, rng: np.random.Generator) -> Integers:
        """The gene with each bit flipped with probability alpha, drawn again until valid."""
        bits = _bits(gene[None])
        while True:
            flipped = bits ^ (rng.random(bits.shape) < self.settings.structure_mutation)
            candidate: Integers = _genes(flipped, len(gene))[0]
            if _tree_index(tuple(candidate.tolist())) is not None:
                return candidate


def two_point(pair: Mask, first: int, behind: int) -> Mask:
    """Two bit strings (2, bits) with the places ``first`` to ``behind - 1`` exchanged."""
    crossed = pair.copy()
    crossed[:, first:behind] = pair[::-1, first:behind]
    return crossed


@cache
def _indices(inputs: int) -> dict[hierarchy.Tree, int]:
    return {tree: k for k, tree in enumerate(hierarchy.trees(inputs))}


@cache
def _tree_index(gene: tuple[int, ...]) -> int | None:
    """Which of ``hierarchy.trees`` a gene decodes to; None where it is invalid."""
    tree = hierarchy.decode(gene)
    return None if tree is None else _indices(len(gene))[tree]


def _bits(genes: Integers) -> Mask:
    """(n, inputs (inputs - 2)) bits of the genes, most significant first."""
    width = genes.shape[1] - 2
    places = np.arange(width - 1, -1, -1)
    return ((genes[:, :, None] >> places) & 1).reshape(len(genes), -1).astype(bool)


def _genes(bits: Mask, inputs: int) -> Integers:
    width = inputs - 2
    places = 2 ** np.arange(width - 1, -1, -1)
    return np.asarray((bits.reshape(len(bits), inputs, width) * places).sum(axis=2))
