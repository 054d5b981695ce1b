"""What a search needs of a scenario: which machines a generation meets, and enough memory."""

from copy import copy
from functools import partial

import numpy as np

from hfc_design.controllers.controller import RateLimited
from hfc_design.controllers.genome import Population, taken
from hfc_design.core.numbers import Floats, Gains, Integers
from hfc_design.core.plugins import own_code
from hfc_design.files.design import Design
from hfc_design.files.scenario import Scenario
from hfc_design.objectives.judge import Judged
from hfc_design.objectives.verdict import Ensemble
from hfc_design.runs.first_laws import FirstLaws, worthwhile
from hfc_design.runs.individuals import genome_of, kinds_of
from hfc_design.runs.judging import Judging
from hfc_design.search.loop import STRATEGIES
from hfc_design.search.strategy import Scored, Task, Weighed
from hfc_design.simulation import memory

#: What the penalty of broken constraints grows to in a search whose scores are compared within a
#: generation only, and the power of the share of its generations by which it grows.
PENALTY, GROWING = 1000.0, 2.0
#: Machines that the points of a front meet where a single design was looked for before; the search
#: for one design meets twice as many in turn.
HARD = 40
#: Power of ``robust.tighter`` that counts there: these machines are hard enough.
TRADED = 0.5
#: How often half of the finalists are left, on twice the machines.
HALVED = 4
#: More than what a design can break.
BEHIND = 1e3
#: A machine is near to breaking a constraint that it breaks if so many times less is allowed.
NEAR = 2.0


class Problem(Judging):
    """A scenario as what a search needs of it."""

    def __init__(self, scenario: Scenario, final: bool = False):
        super().__init__(scenario, final)
        self._traded, self._traded_by = scenario.traded, self._allowed
        if self._robust and self._allowed and not final:
            self._traded_by = self._allowed.tighter(self._robust.tighter**TRADED)
        self._evaluations = scenario.search.population * scenario.search.generations
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
        broken: Floats | None = None,
    ) -> Floats:
        """(n, 2) rank with broken constraints below all others, and what ``rank`` gives."""
        robust, penalty = self._robust, self._penalty(generation)
        if robust is None:
            if not self._single:
                return self._ranked(population, np.zeros(1, int), penalty)
            return self._alone(population, needed)
        some = partial(self._some, generation=generation, hard=hard)
        once = robust.first == robust.elite
        beside = self._beside(self.genome.gains(population)) if broken is None else broken
        first = some(robust.first)
        rank = self._ranked(population, first, penalty, needed if once else None, beside)
        for count in (robust.machines, robust.elite):
            if count == robust.first:
                continue
            # So many that it costs no more than the first round; the others cannot pass them.
            most = max(len(rank) * robust.first // count, 1)
            best = np.argsort(-rank[:, 1], kind="stable")[:most]
            few = taken(population, best)
            found = self._ranked(few, some(count), penalty, beside=beside[best])
            rank = np.minimum(rank, found.min(axis=0))
            rank[best] = found
        return rank

    def scored(
        self,
        population: Population,
        generation: int = 0,
        machines: Integers | None = None,
        needed: Floats | None = None,
        broken: Floats | None = None,
    ) -> Floats | Scored | Weighed:
        """What the strategy of the scenario is told: ranks, or with them what it trades off.

        Costs that are compared are those of the same ``machines``, without them the first ones.
        Where nothing is traded they are the hard ones.
        """
        fresh = generation < self._fresh
        if fresh or not self._traded:
            rank, told = self._met(population, generation, needed, machines, broken).T
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
        rank = self._rank(judged, self._traded_by, beside=self._beside(gains))[:, 0]
        costs = self._costs(judged, gains)
        violation = np.where(rank < 0.0, -rank, 0.0) if self._ensemble else np.zeros(len(rank))
        failed = ~(np.isfinite(rank) & np.isfinite(costs).all(axis=1))
        rank, violation = np.where(failed, -np.inf, rank), np.where(failed, np.inf, violation)
        return Scored(rank, costs, violation)

    def rank_of_finalists(self, population: Population) -> Floats:
        """What they are ranked by: half of them, the best, go on to twice the machines, ``HALVED``.

        The others cannot pass them. One program serves all.
        """
        rank, left = np.full(len(population.tree), np.inf), np.arange(len(population.tree))
        beside = self._beside(self.genome.gains(population))
        lanes = min(len(rank) * self._machines.size, self._lanes)
        judged, done = None, 0
        for count in np.unique(-(-self._machines.size // 2 ** np.arange(HALVED + 1))).tolist():
            gains, some = self.genome.gains(taken(population, left)), np.arange(done, count)
            more = self._eased(gains, some, lanes)
            each = zip(judged, more, strict=True) if judged else ()
            judged = Judged(*(np.concatenate(own, axis=1) for own in each)) if judged else more
            found = self._final_rank(judged, beside[left])
            rank = np.minimum(rank, found.min())
            rank[left], done = found, count
            kept = np.argsort(-found, kind="stable")[: -(-len(left) // 2)]
            left, judged = left[kept], Judged(*(part[kept] for part in judged))
        return rank

    def _final_rank(self, judged: Judged, beside: Floats) -> Floats:
        """As ``rank_on``, but where more is broken than is forgiven it counts on how many machines.

        That is the share of those under no stress and that of the others, of the first machines, as
        the answer asks for both; the nominal machine and what is asked of margins count as all.
        """
        ensemble = self._ensemble
        if ensemble is None:
            return self._rank(judged, None)[:, 0]
        found = ensemble.verdict(judged, beside=beside)
        calm = np.isin(np.arange(judged.failed.shape[1]), self.calm)
        parts = [~found.sound[:, some] for some in (calm, ~calm) if some.any()]
        lost = (beside > 0.0) + ~found.sound[:, 0] + sum(part.mean(axis=1) for part in parts)
        return np.where(found.rank < 0.0, found.rank - BEHIND * lost, found.rank)

    def _penalty(self, generation: int) -> float | None:
        done = generation / self._fresh if self._fresh else 1.0
        return PENALTY * done**GROWING if done < 1.0 else None

    def _some(self, count: int, generation: int, hard: Integers | None) -> Integers:
        """The nominal machine and some others: always the first ones, or others each time."""
        start = generation * (count - 1) if generation < self._fresh else 0
        some = np.append(0, 1 + (start + np.arange(count - 1)) % (self._machines.size - 1))
        if hard is not None and len(hard):
            most = count // 2
            some[count - most :] = hard[(generation * most + np.arange(most)) % len(hard)]
        return some

    def _costs(self, judged: Judged, gains: Gains) -> Floats:
        """(n, objectives) what the search trades off."""
        first = len(self._loop.judge.objectives)
        values = np.asarray(judged.values)[..., first:]
        each = (self._ensemble or Ensemble((1.0,))).costs(values)
        measured = iter(each.T)  # those of constraints come last
        counted = self._record.units_that_matter
        columns = (next(measured) if one.measure else counted(gains) for one in self._traded)
        return np.stack([*columns], axis=1).astype(float)

    def nearest_to_breaking(self, individual: Population, count: int) -> Integers:
        """The machines that a population of one passes on, but with least to spare.

        The nominal one is not among them, nor are those that are forgiven.
        """
        ensemble = self._ensemble or Ensemble((1.0,))
        gains = self.genome.gains(individual)
        judged = self._eased(gains, np.arange(self._machines.size))
        found, near = ensemble.verdict(judged), ensemble.tighter(NEAR).verdict(judged)
        order = np.lexsort((found.merit[0], -near.broken.sum(axis=(2, 3))[0]))
        return order[found.sound[0, order] & (order > 0)][:count]

    @property
    def task(self) -> Task:
        """What a strategy is given; a derivative only where there is one axis to follow."""
        differs = hasattr(self.genome, "space") and self.has_derivative and self._ensemble is None
        hardest = self._hardest if self._robust else None
        linear = self._linear if differs else None
        found = Task(self.genome, linear, hardest, self._informed)
        if self._margins and self._robust:
            return found._replace(
                broken=lambda x: self._beside(self.genome.gains(x)), worth=self.rank
            )
        return found

    def _hardest(self, population: Population, keeping: float) -> Integers:
        """The nominal machine and those on which most is broken, or with least to spare.

        Left out are those on which less than a share ``keeping`` of the ``population`` keeps
        everything by the scenario's own limits.
        """
        assert self._ensemble is not None
        assert self._allowed is not None
        gains = self.genome.gains(population)
        judged = self._eased(gains, np.arange(self._machines.size), self._lanes)
        kept = self._allowed.verdict(judged).sound.mean(axis=0) >= keeping
        found = self._ensemble.verdict(judged)
        broken = found.broken.sum(axis=(2, 3)).mean(axis=0)
        order = np.lexsort((found.merit.mean(axis=0), -broken))
        others = order[kept[order] & (order > 0)]
        calm, most = np.isin(others, self.calm), HARD if keeping else 2 * HARD
        stressed = others[~calm][: 2 * most // 3]  # two thirds of them, or all that there are
        return np.sort(np.concatenate([[0], others[calm][: most - 1 - len(stressed)], stressed]))

    def _informed(self, tree: Integers, rng: np.random.Generator) -> Population | None:
        """First individuals on the given trees, of laws that are searched; None: nobody knows."""
        laws, evaluations = self.genome.laws(), self._evaluations
        if laws is not None and worthwhile(evaluations):
            of_laws = copy(self)
            of_laws.genome = laws
            own, law = self._loop.controller, laws.controller()
            law = own._replace(inner=law) if isinstance(own, RateLimited) else law
            of_laws._loop = self._loop._replace(controller=law)
            of_laws._margins = self._margins and self._margins.of(law)
            of_laws.simulated = 0
            found = FirstLaws(self, of_laws, evaluations).dealt(tree, rng)
            self.simulated += of_laws.simulated
            if found is not None:
                return found
        known: Population | None = self.genome.informed(tree, rng)
        return known


def final_problem(scenario: Scenario) -> Problem:
    """Where finalists compete: on machines within the tolerances themselves.

    In float64 where there is but one, which flatters loops that are nearly chaotic.
    """
    if not scenario.robust:
        own = scenario.run.model_copy(update={"precision": "float64"})
        scenario = scenario.model_copy(update={"run": own})
    return Problem(scenario, final=True)


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
