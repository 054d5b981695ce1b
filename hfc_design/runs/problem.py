"""What a search needs of a scenario: what its individuals are worth there, and enough memory."""

from copy import copy
from functools import partial
from typing import NamedTuple

import numpy as np

from hfc_design.controllers.genome import Population, taken
from hfc_design.controllers.kind import kinds
from hfc_design.core.numbers import Floats, Gains, Integers
from hfc_design.core.plugins import own_code
from hfc_design.files.design import Design
from hfc_design.files.pairing import check_laws, controller_of
from hfc_design.files.scenario import Scenario
from hfc_design.motion.samples import Samples
from hfc_design.objectives.judge import Judged
from hfc_design.objectives.verdict import Ensemble
from hfc_design.runs.first_laws import FirstLaws, worthwhile
from hfc_design.runs.individuals import design_of, genome_of, kinds_of
from hfc_design.search.loop import STRATEGIES
from hfc_design.search.newton import Linear
from hfc_design.search.strategy import Scored, Task, Weighed
from hfc_design.simulation import memory
from hfc_design.simulation import population as simulate
from hfc_design.simulation.closed_loop import Loop, closed_loop
from hfc_design.simulation.machines import drawn
from hfc_design.simulation.population import Machines

#: What the penalty of broken constraints grows to in a search whose scores are compared within a
#: generation only, and the power of the share of its generations by which it grows.
PENALTY, GROWING = 300.0, 2.0
#: Machines that the points of a front meet where a single design was looked for before.
HARD = 40
#: Power of ``robust.tighter`` that counts there: these machines are hard enough.
TRADED = 0.5
#: Machines that everybody meets before it is asked who can still reach what it needs, and how
#: much of that rounding may take away.
FEW, SLACK = 4, 1e-9
#: A machine is near to breaking a constraint that it breaks if so many times less is allowed.
NEAR = 2.0


class Parts(NamedTuple):
    """What a problem simulates."""

    loop: Loop
    machines: Machines
    motions: list[Samples]
    ensemble: Ensemble | None


class Problem:
    """A scenario as what a search needs of it; UserError: its controller cannot be searched."""

    def __init__(self, scenario: Scenario, final: bool = False):
        with own_code("", *kinds_of(scenario.controller.model_dump())):
            self.genome = genome_of(scenario)
            design = design_of(taken(self.genome.empty(), slice(1)), scenario)
        check_laws(design, scenario.plant.machine)
        controller, _ = controller_of(design, scenario)  # that of any individual
        self._loop = closed_loop(scenario, controller)
        self._machines = simulate.one_machine(scenario.plant.values())
        self._samples = [motion.samples() for motion in scenario.each_motion()]
        self._dtype = np.dtype(scenario.run.precision)
        self._ensemble, self._robust = scenario.ensemble, scenario.robust
        if self._robust:
            wider = 1.0 if final else self._robust.margin
            self._machines = drawn_for(scenario, self._robust.final - 1, scenario.run.seed, wider)
        self._allowed = self._traded_by = self._ensemble
        if self._robust and self._allowed and not final:
            self._ensemble = self._allowed.tighter(self._robust.tighter)
            self._traded_by = self._allowed.tighter(self._robust.tighter**TRADED)
        self._evaluations = scenario.search.population * scenario.search.generations
        #: Individuals and machines of a generation.
        self._lanes = scenario.search.population * (self._robust.first if self._robust else 1)
        self._traded, self._record = scenario.traded, design.controller
        #: Whether there is but one machine in one motion, which may end early.
        self._single = not self._ensemble and len(self._samples) == 1 and not self._loop.doubled
        self.simulated = 0  # samples of control of all that were ranked, without derivatives
        #: Generations of which each has machines of its own.
        self._fresh = STRATEGIES.get(scenario.search.preset).forgets(scenario.search)

    def rank(
        self,
        population: Population,
        generation: int = 0,
        needed: Floats | None = None,
        hard: Integers | None = None,
    ) -> Floats:
        """Merit of every individual; -inf where it failed, negative where it is not allowed.

        Where scores of different generations are never compared, broken constraints are weighed
        against merit instead, the more the later. One that cannot reach what is ``needed`` of it
        may have any merit below that.

        Of many machines everybody meets a few, the best of them more. Where scores are not
        compared, each generation has others of the same machines; half of them are ``hard`` ones
        if there are any.
        """
        return self._met(population, generation, needed, hard)[:, 1]

    def _met(
        self,
        population: Population,
        generation: int = 0,
        needed: Floats | None = None,
        hard: Integers | None = None,
    ) -> Floats:
        """(n, 2) rank with broken constraints below all others, and what ``rank`` gives."""
        robust, penalty = self._robust, self._penalty(generation)
        if robust is None:
            if not self._single:
                return self._ranked(population, np.zeros(1, int), penalty)
            least = np.full(len(population.tree), -np.inf) if needed is None else needed
            gains, (samples,) = self.genome.gains(population), self._samples
            about = (self._loop, self._machines, samples, gains, least, self._dtype, self._lanes)
            judged, simulated = simulate.scores_needed(*about)
            self.simulated += int(simulated.sum())
            return self._rank(judged, None)
        some = partial(self._some, generation=generation, hard=hard)
        once = robust.first == robust.elite
        rank = self._ranked(population, some(robust.first), penalty, needed if once else None)
        for count in (robust.machines, robust.elite):
            if count == robust.first:
                continue
            # So many that it costs no more than the first round; the others cannot pass them.
            most = max(len(rank) * robust.first // count, 1)
            best = np.argsort(-rank[:, 1], kind="stable")[:most]
            found = self._ranked(taken(population, best), some(count), penalty)
            rank = np.minimum(rank, found.min(axis=0))
            rank[best] = found
        return rank

    def scored(
        self,
        population: Population,
        generation: int = 0,
        machines: Integers | None = None,
        needed: Floats | None = None,
    ) -> Floats | Scored | Weighed:
        """What the strategy of the scenario is told: ranks, or with them what it trades off.

        Costs that are compared are those of the same ``machines``, without them the first ones.
        Where nothing is traded they are the hard ones.
        """
        fresh = generation < self._fresh
        if fresh or not self._traded:
            rank, told = self._met(population, generation, needed, machines).T
            if fresh and self._traded:  # before it trades
                unknown = np.full((len(rank), len(self._traded)), np.inf)
                return Weighed(rank, Scored(told, unknown, unknown[:, 0]))
            return Weighed(rank, told) if fresh else rank
        count = self._robust.machines if self._robust else 1
        return self.weighed(population, np.arange(count) if machines is None else machines)

    def weighed(self, population: Population, machines: Integers | None = None) -> Scored:
        """Ranks, costs and violations on some machines, or on all that were drawn."""
        some = np.arange(self._machines.size) if machines is None else machines
        gains = self.genome.gains(population)
        judged = self._judged(gains, self._machines.take(some))
        rank, costs = self._rank(judged, self._traded_by)[:, 0], self._costs(judged, gains)
        violation = np.where(rank < 0.0, -rank, 0.0) if self._ensemble else np.zeros(len(rank))
        failed = ~(np.isfinite(rank) & np.isfinite(costs).all(axis=1))
        rank, violation = np.where(failed, -np.inf, rank), np.where(failed, np.inf, violation)
        return Scored(rank, costs, violation)

    def rank_of_finalists(self, population: Population) -> Floats:
        """What they are ranked by: on a quarter of the machines that were drawn, the best on all.

        These are the best quarter; the others cannot pass them.
        """
        every = np.arange(self._machines.size)
        rank = self.rank_on(population, every[: -(-len(every) // 4)])
        best = np.argsort(-rank, kind="stable")[: -(-len(rank) // 4)]
        found = self.rank_on(taken(population, best), every)
        rank = np.minimum(rank, found.min())
        rank[best] = found
        return rank

    def rank_on(self, population: Population, machines: Integers) -> Floats:
        """What they are ranked by on some of the machines that were drawn."""
        return self._ranked(population, machines)[:, 0]

    def _penalty(self, generation: int) -> float | None:
        done = generation / self._fresh if self._fresh else 1.0
        return PENALTY * done**GROWING if done < 1.0 else None

    def _some(self, count: int, generation: int, hard: Integers | None) -> Integers:
        """The nominal machine and some others: always the first ones, or others each time."""
        start = generation * (count - 1) if generation < self._fresh else 0
        some = np.append(0, 1 + (start + np.arange(count - 1)) % (self._machines.size - 1))
        if hard is not None and len(hard):
            half = count // 2
            some[count - half :] = hard[(generation * half + np.arange(half)) % len(hard)]
        return some

    def _ranked(
        self,
        population: Population,
        machines: Integers,
        penalty: float | None = None,
        needed: Floats | None = None,
    ) -> Floats:
        """As ``_met`` on all ``machines``.

        On the first ``FEW`` alone who cannot reach what is ``needed``.
        """
        gains, ensemble = self.genome.gains(population), self._ensemble
        if needed is None or ensemble is None or penalty is not None or len(machines) <= FEW:
            return self._rank(self._judged(gains, self._machines.take(machines)), ensemble, penalty)
        some = self._judged(gains, self._machines.take(machines[:FEW]))
        reach = ensemble.reach(some, len(machines))
        alive = np.flatnonzero((reach >= needed) | np.isclose(reach, needed, rtol=SLACK, atol=0.0))
        rank = np.stack([reach, reach], axis=1)
        if len(alive):
            own, rest = self.genome.gains(taken(population, alive)), machines[FEW:]
            more = self._judged(own, self._machines.take(rest), len(needed) * FEW)
            pairs = zip(some, more, strict=True)
            whole = (np.concatenate([one[alive], other], axis=1) for one, other in pairs)
            rank[alive] = self._rank(Judged(*whole), ensemble)
        return rank

    def _judged(self, gains: Gains, machines: Machines, at_once: int = 0) -> Judged:
        found = simulate.scores(
            self._loop, machines, self._samples, gains, self._dtype, at_once=at_once
        )
        self.simulated += found.merit[..., 0].size * sum(len(x.time) for x in self._samples)
        return found

    def _rank(
        self, judged: Judged, ensemble: Ensemble | None, penalty: float | None = None
    ) -> Floats:
        if ensemble is None:
            return np.stack(2 * [np.asarray(judged.rank[:, 0, 0])], axis=1)
        found = ensemble.verdict(judged, penalty)
        return np.stack([found.rank, found.weighed], axis=1)

    def _costs(self, judged: Judged, gains: Gains) -> Floats:
        """(n, objectives) what the search trades off."""
        first = len(self._loop.judge.objectives)
        values = np.asarray(judged.values)[..., first:]
        each = (self._ensemble or Ensemble((1.0,))).costs(values)
        measured = iter(each.T)  # those of constraints come last
        counted = kinds().get(self._record.kind).units
        columns = (
            next(measured) if one.measure else counted(self._record, gains) for one in self._traded
        )
        return np.stack([*columns], axis=1).astype(float)

    def nearest_to_breaking(self, individual: Population, count: int) -> Integers:
        """The machines that a population of one keeps everything on, but with least to spare.

        The nominal one is not among them, nor are those that are forgiven.
        """
        ensemble = self._ensemble or Ensemble((1.0,))
        judged = self._judged(self.genome.gains(individual), self._machines)
        found, near = ensemble.verdict(judged), ensemble.tighter(NEAR).verdict(judged)
        order = np.lexsort((found.merit[0], -near.broken.sum(axis=(2, 3))[0]))
        return order[found.sound[0, order] & (order > 0)][:count]

    @property
    def parts(self) -> Parts:
        """What is simulated."""
        return Parts(self._loop, self._machines, self._samples, self._ensemble)

    @property
    def has_derivative(self) -> bool:
        """Whether there is one axis to follow, so that its error has a derivative."""
        return len(self._loop.machine.axes) == 1

    @property
    def task(self) -> Task:
        """What a strategy is given; a derivative only where there is one axis to follow."""
        differs = hasattr(self.genome, "space") and self.has_derivative and self._ensemble is None
        hardest = self._hardest if self._robust else None
        return Task(self.genome, self._linear if differs else None, hardest, self._informed)

    def _hardest(self, population: Population, keeping: float) -> Integers:
        """The nominal machine and those on which most is broken, or with least to spare.

        Left out are those on which less than a share ``keeping`` of the ``population`` keeps
        everything by the scenario's own limits.
        """
        assert self._ensemble is not None
        assert self._allowed is not None
        gains = self.genome.gains(population)
        judged = self._judged(gains, self._machines, self._lanes)
        kept = self._allowed.verdict(judged).sound.mean(axis=0) >= keeping
        found = self._ensemble.verdict(judged)
        broken = found.broken.sum(axis=(2, 3)).mean(axis=0)
        order = np.lexsort((found.merit.mean(axis=0), -broken))
        others = order[kept[order] & (order > 0)]
        return np.sort(np.append(0, others[: HARD - 1]))

    def _linear(self, individual: Population, chosen: Integers | None = None) -> Linear | None:
        """The tracking error about one individual; None where it cannot be differentiated."""
        gains = self.genome.gains(individual)
        about = (self._loop, self._machines, *self._samples, gains, self._dtype, chosen)
        error, jacobian = simulate.error_jacobian(*about)
        finite = np.isfinite(error).all() and np.isfinite(jacobian).all()
        return Linear(error, jacobian, chosen) if finite else None

    def _informed(self, tree: Integers, rng: np.random.Generator) -> Population | None:
        """First individuals on the given trees, of laws that are searched; None: nobody knows."""
        laws, evaluations = self.genome.laws(), self._evaluations
        if laws is not None and worthwhile(evaluations):
            of_laws = copy(self)
            of_laws.genome = laws
            of_laws._loop = self._loop._replace(controller=laws.controller())
            of_laws.simulated = 0
            found = FirstLaws(self, of_laws, evaluations).dealt(tree, rng)
            self.simulated += of_laws.simulated
            if found is not None:
                return found
        known: Population | None = self.genome.informed(tree, rng)
        return known

    def largest_signals(self, individual: Population) -> dict[str, float]:
        """What each signal of the first axis reaches at most, on the nominal machine."""
        gains = self.genome.gains(individual)
        return simulate.largest_signals(self._loop, self._machines, self._samples, gains)


def final_problem(scenario: Scenario) -> Problem:
    """Where finalists compete: in float64, on machines within the tolerances themselves."""
    own = scenario.run.model_copy(update={"precision": "float64"})
    return Problem(scenario.model_copy(update={"run": own}), final=True)


def drawn_for(scenario: Scenario, count: int, seed: int, margin: float = 1.0) -> Machines:
    """The nominal machine of a robust scenario and ``count`` others within its tolerances.

    These are wider by the factor ``margin``.
    """
    robust = scenario.robust
    assert robust is not None
    even = robust.sample == "latin-hypercube"
    wider = {name: margin * spread for name, spread in robust.tolerances.items()}
    parts = (scenario.plant, margin * robust.spread, count, seed, wider, even)
    return drawn(*parts, key="robust.spread")[0]


def check_memory(scenario: Scenario, design: Design | None = None, at_once: int = 1) -> None:
    """Refuse a run, or so many ``at_once``, that need more memory than there is.

    Raises:
        UserError: they do.
    """
    if design is None:
        with own_code("", *kinds_of(scenario.controller.model_dump())):
            parts = memory.of_search(scenario, genome_of(scenario))
    else:
        parts = memory.of_motion(scenario)
    memory.check(scenario.name, parts, at_once)
