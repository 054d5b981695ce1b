"""The front of two or three objectives: NSGA-II, with an archive of the best compromises.

Deb, Pratap, Agarwal and Meyarivan, IEEE Trans. Evolutionary Computation 6(2), 2002. What nobody
dominates is kept in an archive of its own, from which parents are chosen too.
"""

from typing import Annotated, Literal, NamedTuple

import numpy as np
from pydantic import AfterValidator, Field

from hfc_design.controllers.genome import Population, joined, replaced, taken
from hfc_design.controllers.hierarchical.record import Bounds
from hfc_design.core.numbers import Floats, Indices, Integers
from hfc_design.core.records import NotNegative, Positive
from hfc_design.objectives.traded import check_names
from hfc_design.search import fronts
from hfc_design.search.strategy import (
    Probability,
    Range,
    Scored,
    Strategy,
    StrategySettings,
    Task,
)

BOUNDS = Bounds()
#: Smallest and largest mutation step, and how much it mutates itself (of its logarithm).
STEPS, SELF = (1e-3, 1.0), 0.3


def _two_or_three(names: tuple[str, ...]) -> tuple[str, ...]:
    check_names(names)
    return names


class Nsga2Settings(StrategySettings):
    """NSGA-II; the objectives are measures by name, ``tracking``, ``effort`` or ``units``."""

    preset: Literal["nsga-ii"] = "nsga-ii"
    population: int = Field(96, ge=4, le=5000)
    generations: int = Field(150, ge=1, le=10_000_000)
    objectives: Annotated[tuple[str, ...], AfterValidator(_two_or_three)] = ("tracking", "effort")
    front: int = Field(48, ge=4, le=1000)  # points that are kept, at most
    tournament: int = Field(2, ge=1)
    blend: Probability = 0.25  # share of children that mix two parents
    step: Positive = 0.2  # first mutation step, relative
    newcomers: Probability = 0.05  # share of children without parents, where structures matter
    stick_penalty: NotNegative = 0.0
    kp_range: Range = BOUNDS.kp_range
    kd_range: Range = BOUNDS.kd_range
    scale_range: float = Field(BOUNDS.scale_range, ge=1)
    inner_limit: float = Field(BOUNDS.inner_limit, gt=0, le=4)
    root_limit: Positive = BOUNDS.root_limit


class Front(NamedTuple):
    """What nobody dominates of all that was tried and keeps every constraint."""

    population: Population
    score: Floats  # (n,)
    costs: Floats  # (n, objectives)
    step: Floats  # (n,) mutation step


class Nsga2State(NamedTuple):
    """The parents, the best first, and the front."""

    population: Population
    score: Floats  # (n,)
    costs: Floats  # (n, objectives)
    violation: Floats  # (n,)
    step: Floats  # (n,) mutation step, inherited and itself mutated
    front: Front


class Asked(NamedTuple):
    """Candidates and the mutation step of each."""

    population: Population
    step: Floats  # (n,)


class Nsga2(NamedTuple):
    """Ask and tell; everything that changes is in ``Nsga2State``."""

    settings: Nsga2Settings
    task: Task

    def start(self, rng: np.random.Generator) -> tuple[None, Asked]:
        """The first individuals, structures as even as they can be."""
        s, structures = self.settings, self.task.genome.structures
        tree = rng.permutation(structures)[np.arange(s.population) % structures]
        steps = np.full(s.population, s.step)
        return None, Asked(self.task.genome.fresh(np.sort(tree), rng), steps)

    def ask(
        self, state: Nsga2State, generation: int, rng: np.random.Generator
    ) -> tuple[Nsga2State, Asked]:
        """Children of the parents and of the front, and a few newcomers."""
        s, genome = self.settings, self.task.genome
        population, step = _pool(state)
        one = _won(rng, len(step), s.tournament, s.population)
        other = _alike(population.tree, one, rng)
        share = np.where(rng.random(len(one)) < s.blend, rng.uniform(-0.25, 1.25, len(one)), 0.0)
        mixed = genome.blended(taken(population, one), taken(population, other), share)
        step = np.clip(step[one] * np.exp(SELF * rng.standard_normal(len(one))), *STEPS)
        children = genome.mutated(mixed, step, rng)
        new = round(s.newcomers * len(one)) if genome.structures > 1 else 0
        if new:
            tree = np.sort(rng.integers(genome.structures, size=new))
            children = replaced(children, np.arange(new), genome.fresh(tree, rng))
            step[:new] = s.step
        return state, Asked(children, step)

    def tell(self, state: Nsga2State | None, asked: Asked, scored: Scored) -> Nsga2State:
        """The best of parents and children remain, and the front takes in what belongs there."""
        children = (asked.population, *scored, asked.step)
        everybody = _Judged(*children)
        if state is not None:
            everybody = _Judged(
                joined(state.population, asked.population),
                *map(np.concatenate, zip(state[1:5], children[1:], strict=True)),
            )
        order = fronts.best_first(everybody.costs, everybody.violation)
        best = _chosen(everybody, order[: self.settings.population])
        return Nsga2State(*best, self._taken_in(state and state.front, _Judged(*children)))

    def _taken_in(self, front: Front | None, children: "_Judged") -> Front:
        new = _chosen(children, np.flatnonzero(children.violation == 0.0))
        found = Front(new.population, new.score, new.costs, new.step)
        if front is not None:
            found = Front(
                joined(front.population, found.population),
                *map(np.concatenate, zip(front[1:], found[1:], strict=True)),
            )
        kept = np.flatnonzero(~fronts.dominated(found.costs, found.costs))
        # Of equal ones the oldest stays.
        kept = kept[np.sort(np.unique(found.costs[kept], axis=0, return_index=True)[1])]
        kept = kept[fronts.spread_out(found.costs[kept], self.settings.front)]
        return Front(taken(found.population, kept), *(leaf[kept] for leaf in found[1:]))


class _Judged(NamedTuple):
    """Individuals with all that is known of them, the first fields of ``Nsga2State``."""

    population: Population
    score: Floats
    costs: Floats
    violation: Floats
    step: Floats


def _chosen(judged: _Judged, chosen: Indices) -> _Judged:
    return _Judged(taken(judged.population, chosen), *(leaf[chosen] for leaf in judged[1:]))


def _pool(state: Nsga2State) -> tuple[Population, Floats]:
    """Those who may become parents, the best first, and their steps."""
    front = state.front
    costs = np.concatenate([state.costs, front.costs])
    violation = np.append(state.violation, np.zeros(len(front.costs)))
    order = fronts.best_first(costs, violation)
    population = taken(joined(state.population, front.population), order)
    return population, np.append(state.step, front.step)[order]


def _won(rng: np.random.Generator, size: int, rounds: int, count: int) -> Integers:
    """Winners of ``count`` tournaments among ``size`` that stand the best first."""
    return (rng.random((rounds, count)).min(axis=0) * size).astype(np.int64)


def _alike(tree: Integers, one: Integers, rng: np.random.Generator) -> Integers:
    """For each of ``one`` any individual of the same structure, perhaps itself."""
    order = np.argsort(tree, kind="stable")
    first = np.searchsorted(tree[order], tree[one])
    count = np.searchsorted(tree[order], tree[one], side="right") - first
    return order[first + (rng.random(len(one)) * count).astype(np.int64)]


def _sound(settings: Nsga2Settings, state: Nsga2State) -> bool:
    front, several = state.front, len(settings.objectives)
    each = state.score, state.violation, state.step, state.population.tree
    own = front.score, front.step, front.population.tree
    points = len(front.costs)
    return (
        all(array.shape == (settings.population,) for array in each)
        and state.costs.shape == (settings.population, several)
        and front.costs.shape == (points, several)
        and points <= settings.front
        and all(array.shape == (points,) for array in own)
        and bool((state.violation >= 0.0).all())
        and bool(np.isfinite(state.costs[state.violation == 0.0]).all())
        and all(bool(((step > 0.0) & (step < np.inf)).all()) for step in (state.step, front.step))
        and bool(np.isfinite(front.costs).all() and np.isfinite(front.score).all())
        and not fronts.dominated(front.costs, front.costs).any()
    )


STRATEGY = Strategy(
    "nsga-ii",
    Nsga2Settings,
    Nsga2State,
    Nsga2,
    "the front of two or three objectives (NSGA-II), as hfc design --pareto asks for it",
    sound=_sound,
    trades=lambda settings: settings.objectives,
)
