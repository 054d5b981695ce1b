"""The search problem of a scenario: individuals simulated on its machines, judged and ranked."""

from contextlib import suppress
from copy import copy
from functools import partial
from typing import Any

import numpy as np

from hfc_design.controllers.controller import RateLimited
from hfc_design.controllers.genome import Population, taken
from hfc_design.core.numbers import Floats, Gains, Integers
from hfc_design.core.plugins import own_code
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.files.loop_setup import check_laws, controller_of
from hfc_design.files.scenario import Scenario
from hfc_design.objectives.judge import Judged
from hfc_design.objectives.verdict import Ensemble
from hfc_design.runs.first_laws import FEWEST, first_laws
from hfc_design.runs.individuals import design_of, genome_of, kinds_of
from hfc_design.search.loop import STRATEGIES
from hfc_design.search.newton import Linear
from hfc_design.search.strategy import Scored, Task, Weighed
from hfc_design.simulation import memory
from hfc_design.simulation import population as simulate
from hfc_design.simulation.closed_loop import Loop, closed_loop
from hfc_design.simulation.loop_margins import AskedMargins
from hfc_design.simulation.machines import drawn
from hfc_design.simulation.population import Machines
from hfc_design.simulation.stepping import trailing
from hfc_design.simulation.stress import Applied, among, rubbing

#: Number of machines on which all individuals are simulated before those that cannot reach the
#: needed rank are dropped, and tolerance of this comparison for rounding.
FEW, SLACK = 4, 1e-9
#: Offset of the seed of the machines on which the final choice is made.
CHOSEN = 2**33
#: Final penalty of violated constraints in a search that compares scores only within a generation,
#: and power of the share of completed generations with which the penalty grows.
PENALTY, GROWING = 1000.0, 2.0
#: Number of hard machines for a front, after a leading search for a single design; a search for a
#: single design uses twice as many, in turn.
HARD = 40
#: Exponent of ``robust.tighter`` for a front, whose machines are hard already.
TRADED = 0.5
#: Number of times that the finalists are halved, each time on twice the machines.
HALVED = 4
#: Number larger than any violation of a design.
BEHIND = 1e3
#: Number of machines with the friction of the stress; they are the same in all runs.
RUBBING = 199
#: A machine is close to a violation if dividing the limits by this factor causes one.
NEAR = 2.0


class Problem:
    """A scenario with its genome, loop, machines and motions, and the ranking of individuals.

    With ``final``, it is the problem of the choice among finalists: on other machines, by the
    scenario's tolerances and constraints. A search has wider tolerances and tighter constraints.

    Raises:
        UserError: the controller of the scenario cannot be searched.
    """

    def __init__(self, scenario: Scenario, final: bool = False):
        with own_code("", *kinds_of(scenario.controller.model_dump())):
            self.genome = genome_of(scenario)
            design = design_of(self.genome.empty(), scenario)  # for the signals that all read
        check_laws(design, scenario.plant.machine)
        controller, _ = controller_of(design, scenario)  # same law for all individuals
        self._record, self._traded = design.controller, scenario.traded
        self._robust = robust = scenario.robust
        delay = scenario.stress.delay_samples if robust else None
        self.loop = closed_loop(scenario, controller, delay)
        self.machines = simulate.one_machine(scenario.plant.values())
        #: Indices of the machines that are under no stress.
        self.calm = np.zeros(1, int)
        if robust:
            wider, seed = 1.0 if final else robust.margin, scenario.run.seed + CHOSEN * final
            within = drawn_for(scenario, robust.final - 1, seed, wider)
            self.machines, self.calm = among(within, scenario, self.loop)
        self._tighter = robust.tighter if robust and not final else 1.0
        self._allowed = scenario.ensemble
        self.ensemble = self._allowed and self._allowed.tighter(self._tighter)
        self.motions = [x.samples() for x in scenario.each_motion()]
        self._margins = margin_limits(scenario, self.loop, self.genome, final)
        self._dtype = np.dtype(scenario.run.precision)
        settings = scenario.search
        self._evaluations = settings.population * settings.generations
        #: Number of pairs of an individual and a machine in a generation.
        self._lanes = settings.population * (robust.first if robust else 1)
        #: Number of generations that each have machines of their own.
        self._fresh = STRATEGIES.get(settings.preset).forgets(settings)
        self.simulated = 0  # control samples simulated for ranks, not for derivatives

    @property
    def has_derivative(self) -> bool:
        """True if the machine has a single axis, whose tracking error has a derivative."""
        return len(self.loop.machine.axes) == 1

    @property
    def task(self) -> Task:
        """The task of a strategy; it has a derivative only for one axis and without an ensemble."""
        differs = hasattr(self.genome, "space") and self.has_derivative and not self.ensemble
        by_margins = self._margins and self._robust
        return Task(
            self.genome,
            self._linear if differs else None,
            self._hardest if self._robust else None,
            self._informed,
            (lambda x: self._beyond_margins(self.genome.gains(x))) if by_margins else None,
            self.rank if by_margins else None,
        )

    def rank(
        self,
        population: Population,
        generation: int = 0,
        needed: Floats | None = None,
        hard: Integers | None = None,
    ) -> Floats:
        """Return the merit of each individual (n,): -inf if it failed, negative for violations.

        If scores of different generations are never compared, violated constraints are weighed
        against merit instead, with increasing weight. The merit of an individual that cannot reach
        its ``needed`` value is any number below it.

        With several machines, all individuals are simulated on a few, and the best of them on more.
        If scores of generations are never compared, each generation uses other machines of the same
        set; half of them are ``hard`` ones if there are any.
        """
        return self._in_rounds(population, generation, needed, hard)[:, 1]

    def scored(
        self,
        population: Population,
        generation: int = 0,
        machines: Integers | None = None,
        needed: Floats | None = None,
        broken: Floats | None = None,
    ) -> Floats | Scored | Weighed:
        """Return scores for the strategy of the scenario: ranks, for a trade-off also costs.

        Costs are those on ``machines`` (default: the first ones), so that they can be compared.
        Without a trade-off, ``machines`` are the ``hard`` ones of ``rank``.
        """
        fresh = generation < self._fresh
        if self._traded and not fresh:
            count = self._robust.machines if self._robust else 1
            return self.weighed(population, np.arange(count) if machines is None else machines)
        rank, weighed = self._in_rounds(population, generation, needed, machines, broken).T
        if fresh and self._traded:  # before it trades
            unknown = np.full((len(rank), len(self._traded)), np.inf)
            return Weighed(rank, Scored(weighed, unknown, unknown[:, 0]))
        return Weighed(rank, weighed) if fresh else rank

    def weighed(self, population: Population, machines: Integers | None = None) -> Scored:
        """Return ranks, costs and violations on some machines; default: all that were drawn."""
        gains = self.genome.gains(population)
        judged = self._simulated(gains, self._every if machines is None else machines)
        allowed = self._allowed and self._allowed.tighter(self._tighter**TRADED)
        rank = self._verdict(judged, allowed, beyond=self._beyond_margins(gains))[:, 0]
        costs = self._costs(judged, gains)
        violation = np.where(rank < 0.0, -rank, 0.0) if allowed else np.zeros(len(rank))
        failed = ~(np.isfinite(rank) & np.isfinite(costs).all(axis=1))
        rank, violation = np.where(failed, -np.inf, rank), np.where(failed, np.inf, violation)
        return Scored(rank, costs, violation)

    def rank_on(self, population: Population, machines: Integers, at_once: int = 0) -> Floats:
        """Return ranks (n,) on some of the drawn machines.

        ``at_once`` pairs of an individual and a machine are simulated together; default: all.
        """
        return self._ranked(population, machines, at_once=at_once)[:, 0]

    def rank_of_finalists(self, population: Population) -> Floats:
        """Return ranks (n,); ``HALVED`` times, the better half advances to twice the machines.

        A finalist never ranks above one that has advanced further. One program serves all rounds.
        """
        rank, left = np.full(len(population.tree), np.inf), np.arange(len(population.tree))
        beyond = self._beyond_margins(self.genome.gains(population))
        size = self.machines.size
        judged, done = None, 0
        for count in np.unique(-(-size // 2 ** np.arange(HALVED + 1))).tolist():
            gains, some = self.genome.gains(taken(population, left)), np.arange(done, count)
            more = self._judged(gains, some, min(len(rank) * size, self._lanes))
            judged = _on_both(judged, more) if judged else more
            ranks = self._final_rank(judged, beyond[left])
            rank = np.minimum(rank, ranks.min())
            rank[left], done = ranks, count
            best = np.argsort(-ranks, kind="stable")[: -(-len(left) // 2)]
            left, judged = left[best], Judged(*(part[best] for part in judged))
        return rank

    def nearest_to_breaking(self, individual: Population, count: int) -> Integers:
        """Return up to ``count`` machines on which a population of one is closest to a violation.

        The nominal machine is left out, and so are machines on which the individual does not pass.
        """
        ensemble = self.ensemble or Ensemble((1.0,))
        judged = self._judged(self.genome.gains(individual), self._every)
        verdict, near = ensemble.verdict(judged), ensemble.tighter(NEAR).verdict(judged)
        order = np.lexsort((verdict.merit[0], -near.broken.sum(axis=(2, 3))[0]))
        return order[verdict.sound[0, order] & (order > 0)][:count]

    def largest_signals(self, individual: Population) -> dict[str, float]:
        """Return the largest magnitude of each signal of the first axis on the nominal machine."""
        gains = self.genome.gains(individual)
        return simulate.largest_signals(self.loop, self.machines, self.motions, gains)

    @property
    def _every(self) -> Integers:
        return np.arange(self.machines.size)

    def _in_rounds(
        self,
        population: Population,
        generation: int = 0,
        needed: Floats | None = None,
        hard: Integers | None = None,
        beyond: Floats | None = None,
    ) -> Floats:
        """Return (n, 2): rank with violations below all others, and the result of ``rank``."""
        robust, penalty = self._robust, self._penalty(generation)
        if robust is None:
            if self.ensemble or len(self.motions) > 1 or self.loop.doubled:
                return self._ranked(population, np.zeros(1, int), penalty)
            return self._ranked_alone(population, needed)
        some = partial(self._some, generation=generation, hard=hard)
        if beyond is None:
            beyond = self._beyond_margins(self.genome.gains(population))
        needed = needed if robust.first == robust.elite else None
        rank = self._ranked(population, some(robust.first), penalty, needed, beyond)
        for count in (robust.machines, robust.elite):
            if count == robust.first:
                continue
            # So many that it costs no more than the first round; others cannot rank above them.
            most = max(len(rank) * robust.first // count, 1)
            best = np.argsort(-rank[:, 1], kind="stable")[:most]
            again = self._ranked(taken(population, best), some(count), penalty, beyond=beyond[best])
            rank = np.minimum(rank, again.min(axis=0))
            rank[best] = again
        return rank

    def _ranked(
        self,
        population: Population,
        machines: Integers,
        penalty: float | None = None,
        needed: Floats | None = None,
        beyond: Floats | None = None,
        at_once: int = 0,
    ) -> Floats:
        """Return (n, 2): rank with violations below all others, and rank with weighed violations.

        Individuals are simulated on all ``machines``; those that cannot reach their ``needed``
        value, only on the first ``FEW``.
        """
        gains, ensemble = self.genome.gains(population), self.ensemble
        beyond = self._beyond_margins(gains) if beyond is None else beyond
        if needed is None or ensemble is None or penalty is not None or len(machines) <= FEW:
            return self._verdict(self._judged(gains, machines, at_once), ensemble, penalty, beyond)
        some = self._judged(gains, machines[:FEW])
        bound = ensemble.best_rank(some, len(machines), beyond)
        alive = np.flatnonzero((bound >= needed) | np.isclose(bound, needed, rtol=SLACK, atol=0.0))
        rank = np.stack([bound, bound], axis=1)
        if len(alive):
            gains = self.genome.gains(taken(population, alive))
            more = self._judged(gains, machines[FEW:], len(needed) * FEW)
            whole = _on_both(Judged(*(part[alive] for part in some)), more)
            rank[alive] = self._verdict(whole, ensemble, beyond=beyond[alive])
        return rank

    def _ranked_alone(self, population: Population, needed: Floats | None) -> Floats:
        """As ``_ranked`` on one machine in one motion, stopped early where ``needed`` is missed."""
        least = np.full(len(population.tree), -np.inf) if needed is None else needed
        (samples,), gains = self.motions, self.genome.gains(population)
        about = (self.loop, self.machines, samples, gains, least)
        judged, simulated = simulate.scores_needed(*about, self._dtype, self._lanes)
        self.simulated += int(simulated.sum())
        return self._verdict(judged, None)

    def _judged(self, gains: Gains, machines: Integers, at_once: int = 0) -> Judged:
        """Simulate and judge individuals on some of the machines.

        On machines under a stress, a search does not tighten the constraints of the scenario.
        """
        judged = self._simulated(gains, machines, at_once)
        ensemble, stressed = self.ensemble, ~np.isin(machines, self.calm)
        if ensemble is None or self._tighter == 1.0 or not stressed.any():
            return judged
        values, count = np.array(judged.values), len(ensemble.constraints)
        values[:, stressed, :, values.shape[-1] - count :] /= self._tighter
        return judged._replace(values=values)

    def _simulated(self, gains: Gains, machines: Integers, at_once: int = 0) -> Judged:
        about = (self.loop, self.machines.take(machines), self.motions, gains)
        judged = simulate.scores(*about, self._dtype, at_once=at_once)
        self.simulated += judged.merit[..., 0].size * sum(len(x.time) for x in self.motions)
        return judged

    def _beyond_margins(self, gains: Gains) -> Floats:
        """Return the violation of the required margins of the loops, (n,)."""
        return self._margins.broken(gains) if self._margins else np.zeros(trailing(gains))

    def _verdict(
        self,
        judged: Judged,
        ensemble: Ensemble | None,
        penalty: float | None = None,
        beyond: Floats | float = 0.0,
    ) -> Floats:
        """Return (n, 2) as ``_ranked`` does, from results of the simulation."""
        if ensemble is None:
            return np.stack(2 * [np.asarray(judged.rank[:, 0, 0])], axis=1)
        verdict = ensemble.verdict(judged, penalty, beyond)
        return np.stack([verdict.rank, verdict.weighed], axis=1)

    def _final_rank(self, judged: Judged, beyond: Floats) -> Floats:
        """As ``rank_on``, but if constraints are violated, the failing machines are counted first.

        The shares that fail without and with a stress are added, as the final test uses both; a
        failing nominal machine counts as all machines, and so do missed margins.
        """
        if self.ensemble is None:
            return self._verdict(judged, None)[:, 0]
        verdict = self.ensemble.verdict(judged, more_violation=beyond)
        calm = np.isin(np.arange(judged.failed.shape[1]), self.calm)
        parts = [~verdict.sound[:, some] for some in (calm, ~calm) if some.any()]
        lost = (beyond > 0.0) + ~verdict.sound[:, 0] + sum(part.mean(axis=1) for part in parts)
        return np.where(verdict.rank < 0.0, verdict.rank - BEHIND * lost, verdict.rank)

    def _penalty(self, generation: int) -> float | None:
        done = generation / self._fresh if self._fresh else 1.0
        return PENALTY * done**GROWING if done < 1.0 else None

    def _some(self, count: int, generation: int, hard: Integers | None) -> Integers:
        """Return the nominal machine and ``count - 1`` more; see ``rank`` for when they change."""
        start = generation * (count - 1) if generation < self._fresh else 0
        some = np.append(0, 1 + (start + np.arange(count - 1)) % (self.machines.size - 1))
        if hard is not None and len(hard):
            most = count // 2
            some[count - most :] = hard[(generation * most + np.arange(most)) % len(hard)]
        return some

    def _costs(self, judged: Judged, gains: Gains) -> Floats:
        """Return the costs of the trade-off, (n, objectives)."""
        values = np.asarray(judged.values)[..., len(self.loop.judge.objectives) :]
        costs = (self.ensemble or Ensemble((1.0,))).costs(values)
        measured = iter(costs.T)  # values of constraints come last
        units = self._record.units_that_matter
        columns = (next(measured) if x.metric else units(gains) for x in self._traded)
        return np.stack([*columns], axis=1).astype(float)

    def _linear(self, individual: Population, chosen: Integers | None = None) -> Linear | None:
        """Return the tracking error linearised around an individual; None if it is not finite."""
        (samples,), gains = self.motions, self.genome.gains(individual)
        about = (self.loop, self.machines, samples, gains, ("error",))
        error, jacobian = simulate.jacobians(*about, self._dtype, chosen)["error"]
        finite = np.isfinite(error).all() and np.isfinite(jacobian).all()
        return Linear(error, jacobian, chosen) if finite else None

    def _hardest(self, population: Population, keeping: float) -> Integers:
        """Return the nominal machine and those with the largest violations, then lowest merits.

        A machine is left out if less than a share ``keeping`` of the ``population`` meets all
        constraints of the scenario on it.
        """
        assert self.ensemble is not None
        assert self._allowed is not None
        judged = self._judged(self.genome.gains(population), self._every, self._lanes)
        possible = self._allowed.verdict(judged).sound.mean(axis=0) >= keeping
        verdict = self.ensemble.verdict(judged)
        broken = verdict.broken.sum(axis=(2, 3)).mean(axis=0)
        order = np.lexsort((verdict.merit.mean(axis=0), -broken))
        others = order[possible[order] & (order > 0)]
        calm, most = np.isin(others, self.calm), HARD if keeping else 2 * HARD
        stressed = others[~calm][: 2 * most // 3]  # at most two thirds of all
        return np.sort(np.concatenate([[0], others[calm][: most - 1 - len(stressed)], stressed]))

    def _informed(self, tree: Integers, rng: np.random.Generator) -> Population | None:
        """Return first individuals on the given trees, from laws that are searched or known."""
        laws = self.genome.laws()
        if laws is not None and self._evaluations >= FEWEST:
            of_laws = copy(self)
            of_laws.genome, of_laws.simulated = laws, 0
            whole, law = self.loop.controller, laws.controller()
            law = whole._replace(inner=law) if isinstance(whole, RateLimited) else law
            of_laws.loop = self.loop._replace(controller=law)
            of_laws._margins = self._margins and self._margins.of(law)
            first = first_laws(self, of_laws, self._evaluations, tree, rng)
            self.simulated += of_laws.simulated
            if first is not None:
                return first
        known: Population | None = self.genome.informed(tree, rng)
        return known


def _on_both(some: Judged, others: Judged) -> Judged:
    """Join the results of the same individuals on some machines and on others."""
    pairs = zip(some, others, strict=True)
    return Judged(*(np.concatenate(pair, axis=1) for pair in pairs))


def drawn_for(scenario: Scenario, count: int, seed: int, margin: float = 1.0) -> Machines:
    """Return the nominal machine of a robust scenario and ``count`` others within its tolerances.

    The tolerances are widened by the factor ``margin``.
    """
    robust = scenario.robust
    assert robust is not None
    even = robust.sample == "latin-hypercube"
    wider = {name: margin * spread for name, spread in robust.tolerances.items()}
    parts = (scenario.plant, margin * robust.spread, count, seed, wider, even)
    return drawn(*parts, key="robust.spread")[0]


def margin_limits(scenario: Scenario, loop: Loop, genome: Any, final: bool) -> AskedMargins | None:
    """Return the margins that the scenario requires of the linearised loop; None: it requires none.

    With ``final``, they are those for finalists. A robust scenario requires at least stability, if
    the stability of such laws can be determined.
    """
    robust, friction, machines = scenario.robust, scenario.stress.friction, None
    if not scenario.margins and not robust:
        return None
    if scenario.margins and robust and friction > 1.0:
        within = drawn_for(scenario, RUBBING, 0)
        machines = rubbing(scenario, within, Applied(friction=friction))
    with suppress(*[UserError] * (not scenario.margins)):
        limits = AskedMargins(scenario, loop, machines, final)
        limits.broken(genome.gains(genome.empty()))
        return limits
    return None


def final_problem(scenario: Scenario) -> Problem:
    """Return the problem of the final choice, on machines within the tolerances of the scenario.

    With only one machine, it is in float64, since float32 overrates loops that are nearly chaotic.
    """
    if not scenario.robust:
        run = scenario.run.model_copy(update={"precision": "float64"})
        scenario = scenario.model_copy(update={"run": run})
    return Problem(scenario, final=True)


def check_memory(scenario: Scenario, design: Design | None = None, at_once: int = 1) -> None:
    """Refuse a run, or ``at_once`` ones together, if memory is too small for it (UserError)."""
    if design is None:
        with own_code("", *kinds_of(scenario.controller.model_dump())):
            parts = memory.of_search(scenario, genome_of(scenario))
    else:
        parts = memory.of_motion(scenario)
    memory.check(scenario.name, parts, at_once)
