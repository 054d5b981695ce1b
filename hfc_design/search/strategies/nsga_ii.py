"""NSGA-II: the front of two or three objectives, with an archive of the best compromises.

Deb, Pratap, Agarwal and Meyarivan, IEEE Trans. Evolutionary Computation 6(2), 2002. Non-dominated
individuals are kept in a separate archive, the front, from which parents are chosen too.

If constraints are so hard that random individuals never meet all of them, a search for a single
design (CMA-ES), the *leading search*, may go first; the front then spreads from its result.
"""

from typing import Annotated, Literal, NamedTuple, Self

import numpy as np
from pydantic import AfterValidator, Field, model_validator

from hfc_design.controllers.genome import Genome, Population, joined, replaced, taken
from hfc_design.controllers.hierarchical.record import Bounds
from hfc_design.controllers.kind import ControllerSettings
from hfc_design.core.numbers import Floats, Integers
from hfc_design.core.records import NotNegative, Ordered, Positive
from hfc_design.objectives.metrics import named
from hfc_design.objectives.traded import UNITS, check_names
from hfc_design.search import fronts
from hfc_design.search.distribution import Distribution
from hfc_design.search.nondominated_archive import Front, Judged, best_first, insert
from hfc_design.search.strategies import cma
from hfc_design.search.strategy import Probability, Scored, Strategy, StrategySettings, Task

#: Smallest and largest mutation step, and standard deviation of the mutation of its logarithm.
STEPS, SELF = (1e-3, 1.0), 0.3
#: Share of the leading search's individuals that has to pass on a machine of the front.
KEEPING = 0.5
#: Smallest first mutation step of the individuals that the leading search found.
FINE = 0.01


def _two_or_three(names: tuple[str, ...]) -> tuple[str, ...]:
    check_names(objectives := tuple(named(name) for name in names))
    return objectives


class Nsga2Settings(Ordered, Bounds, StrategySettings):
    """NSGA-II; an objective is ``tracking``, ``effort``, ``units`` or the name of a metric."""

    keys_last = Bounds.model_fields
    preset: Literal["nsga-ii"] = "nsga-ii"
    population: int = Field(32, ge=4, le=5000)
    generations: int = Field(450, ge=1, le=10_000_000)
    #: two or three objectives of the front
    objectives: Annotated[tuple[str, ...], AfterValidator(_two_or_three)] = ("tracking", "effort")
    front: int = Field(48, ge=4, le=1000)  # largest number of points of the front
    #: number of initial generations that search for a single design (cma)
    lead: int = Field(0, ge=0)
    #: individuals of a tournament, of which the best becomes a parent
    tournament: int = Field(2, ge=1)
    blend: Probability = 0.25  # share of children from two parents [1]
    step: Positive = 0.2  # first mutation step, relative [1]
    newcomers: Probability = 0.05  # share of children without parents, where structures matter [1]
    stick_penalty: NotNegative = 0.0  # ranked by fitness / (1 + this times the stick share) [1]

    @model_validator(mode="after")
    def _room_for_a_front(self) -> Self:
        if self.lead >= self.generations:
            raise ValueError("lead must be less than generations")
        return self


class Nsga2State(NamedTuple):
    """The parents, the best first, and the front."""

    population: Population
    score: Floats  # (n,)
    costs: Floats  # (n, objectives)
    violation: Floats  # (n,)
    step: Floats  # (n,) mutation step, inherited and itself mutated
    front: Front
    led: cma.CmaState  # state of the leading search; without islands if there is none
    machines: Integers  # indices of the machines for the front; empty: the scenario's first ones


class Asked(NamedTuple):
    """Candidates and the mutation step of each."""

    population: Population
    step: Floats  # (n,)
    machines: Integers | None = None
    sampled: cma.Asked | None = None  # samples of the leading search; None: the front is searched
    structures: int | None = None  # number of structures that compete in the leading search


class Nsga2(NamedTuple):
    """The strategy; everything that changes is in ``Nsga2State``."""

    settings: Nsga2Settings
    task: Task

    def start(self, rng: np.random.Generator) -> tuple[Nsga2State | None, Asked]:
        """Return first individuals, evenly over structures, or samples of the leading search."""
        s, structures = self.settings, self.task.genome.structures
        if s.lead:
            led, samples = self._leader.start(rng)
            return _only(led, s), _sampled(samples, s)
        tree = rng.permutation(structures)[np.arange(s.population) % structures]
        steps = np.full(s.population, s.step)
        return None, Asked(self.task.genome.fresh(np.sort(tree), rng), steps)

    def ask(
        self, state: Nsga2State, generation: int, rng: np.random.Generator
    ) -> tuple[Nsga2State, Asked]:
        """Return children of parents and front, or at first what the leading search proposes."""
        s = self.settings
        if generation < s.lead:
            led, samples = self._leader.ask(state.led, generation, rng)
            return state._replace(led=led), _sampled(samples, s)
        if generation > s.lead or not s.lead:
            candidates = self._children(state, rng)
        else:  # from now on all are simulated on the same, hard machines
            best = joined(state.led.population, state.population)
            population = joined(best, state.led.trail)
            candidates = Asked(population, np.geomspace(FINE, s.step, len(population.tree)))
            hard = self.task.hardest(best, KEEPING) if self.task.hardest else state.machines
            state = _only(state.led, s)._replace(machines=hard)
        return state, candidates._replace(machines=state.machines if len(state.machines) else None)

    def _children(self, state: Nsga2State, rng: np.random.Generator) -> Asked:
        s, genome = self.settings, self.task.genome
        population, step = _pool(state)
        drawn = rng.random((s.tournament, s.population)).min(axis=0)  # the best come first
        one = (drawn * len(step)).astype(np.int64)
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
        return Asked(children, step)

    def tell(self, state: Nsga2State | None, candidates: Asked, scored: Scored) -> Nsga2State:
        """Return the state with the best of parents and children, and the updated front."""
        s, genome = self.settings, self.task.genome
        children = Judged(candidates.population, *scored, candidates.step)
        state = state or _only(_nothing(genome), s)
        if candidates.sampled is not None:  # not comparable with earlier ones
            led = self._leader.tell(state.led, candidates.sampled, scored.score)
            return Nsga2State(*children, state.front, led, state.machines)
        everybody = joined(Judged(*state[:5]), children)
        units = everybody.costs[:, s.objectives.index(UNITS)] if UNITS in s.objectives else None
        best = taken(everybody, best_first(everybody, units)[: s.population])
        return Nsga2State(*best, insert(state.front, children, s.front), *state[6:])

    @property
    def _leader(self) -> cma.Cma:
        return cma.Cma(_leading(self.settings), self.task)


def _nothing(genome: Genome) -> cma.CmaState:
    """Return the state of a leading search without islands."""
    nobody, islands = taken(genome.empty(), slice(0)), Distribution(*np.empty((7, 0, 0)))
    return cma.CmaState(nobody, np.empty(0), nobody, nobody, islands, np.empty(0, np.int64))


def _only(led: cma.CmaState, settings: Nsga2Settings) -> Nsga2State:
    """Return a state with a leading search and no individuals yet."""
    nobody, none = taken(led.population, slice(0)), np.empty(0)
    costs = np.empty((0, len(settings.objectives)))
    front = Front(nobody, none, costs, none)
    return Nsga2State(nobody, none, costs, none, none, front, led, np.empty(0, np.int64))


def _leading(settings: Nsga2Settings) -> cma.CmaSettings:
    return cma.CmaSettings(generations=settings.lead)


def _sampled(samples: cma.Asked, settings: Nsga2Settings) -> Asked:
    steps = np.full(len(samples.points), settings.step)
    return Asked(samples.population, steps, samples.machines, samples, samples.structures)


def _pool(state: Nsga2State) -> tuple[Population, Floats]:
    """Return all possible parents, the best first, and their mutation steps."""
    front = state.front
    costs = np.concatenate([state.costs, front.costs])
    violation = np.append(state.violation, np.zeros(len(front.costs)))
    order = fronts.best_first(costs, violation)
    population = taken(joined(state.population, front.population), order)
    return population, np.append(state.step, front.step)[order]


def _alike(tree: Integers, one: Integers, rng: np.random.Generator) -> Integers:
    """Return, for each index in ``one``, a random one of the same structure, perhaps itself."""
    order = np.argsort(tree, kind="stable")
    first = np.searchsorted(tree[order], tree[one])
    count = np.searchsorted(tree[order], tree[one], side="right") - first
    return order[first + (rng.random(len(one)) * count).astype(np.int64)]


def _fault(settings: Nsga2Settings, controller: ControllerSettings) -> str | None:
    if settings.lead and not controller.staged:
        return f"has no lead for controllers of kind {controller.kind}: search.lead must be 0"
    return None


def _sound(settings: Nsga2Settings, state: Nsga2State) -> bool:
    front, several = state.front, len(settings.objectives)
    each = state.score, state.violation, state.step, state.population.tree
    front_arrays = front.score, front.step, front.population.tree
    points = len(front.costs)
    led = settings.lead == 0 or cma.STRATEGY.sound(_leading(settings), state.led)
    count = len(state.step)
    return (
        led
        and state.machines.ndim == 1
        and bool((state.machines >= 0).all())
        and all(array.shape == (count,) for array in each)
        and state.costs.shape == (count, several)
        and front.costs.shape == (points, several)
        and points <= settings.front
        and all(array.shape == (points,) for array in front_arrays)
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
    "the Pareto front of two or three objectives (NSGA-II), for hfc design --pareto",
    _fault,
    _sound,
    forgets=lambda settings: settings.lead,
    trades=lambda settings: settings.objectives,
)
