"""What individuals are worth on machines of a scenario: simulated, judged and ranked."""

from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np

from hfc_design.controllers.genome import Population, taken
from hfc_design.core.numbers import Floats, Gains, Integers
from hfc_design.core.plugins import own_code
from hfc_design.core.records import UserError
from hfc_design.files.pairing import check_laws, controller_of
from hfc_design.files.scenario import Scenario
from hfc_design.motion.samples import Samples
from hfc_design.objectives.judge import Judged
from hfc_design.objectives.verdict import Ensemble
from hfc_design.runs.individuals import design_of, genome_of, kinds_of
from hfc_design.search.newton import Linear
from hfc_design.simulation import population as simulate
from hfc_design.simulation.closed_loop import Loop, closed_loop
from hfc_design.simulation.loop_margins import AskedMargins
from hfc_design.simulation.machines import drawn
from hfc_design.simulation.population import Machines
from hfc_design.simulation.stepping import trailing
from hfc_design.simulation.stress import Applied, among, rubbing

#: Machines that everybody meets before it is asked who can still reach what it needs, and how
#: much of that rounding may take away.
FEW, SLACK = 4, 1e-9
#: The machines on which the choice is made in the end are drawn with a seed so far beyond.
CHOSEN = 2**33
#: So many machines are sorted by how they slide, the same in all runs.
RUBBING = 199


class Parts(NamedTuple):
    """What a problem simulates."""

    loop: Loop
    machines: Machines
    motions: list[Samples]
    ensemble: Ensemble | None


class Judging:
    """A scenario with its genome, loop, machines and motions, and what ranks there.

    UserError: its controller cannot be searched.
    """

    def __init__(self, scenario: Scenario, final: bool = False):
        with own_code("", *kinds_of(scenario.controller.model_dump())):
            self.genome = genome_of(scenario)
            design = design_of(self.genome.empty(), scenario)  # what any of them reads
        check_laws(design, scenario.plant.machine)
        controller, _ = controller_of(design, scenario)  # that of any individual
        later = scenario.stress.delay_samples if scenario.robust else None
        self._loop = closed_loop(scenario, controller, later)
        self._machines = simulate.one_machine(scenario.plant.values())
        self._samples = [motion.samples() for motion in scenario.each_motion()]
        self._dtype = np.dtype(scenario.run.precision)
        self._ensemble, self._robust = scenario.ensemble, scenario.robust
        if self._robust:
            wider = 1.0 if final else self._robust.margin
            seed = scenario.run.seed + CHOSEN * final
            own = drawn_for(scenario, self._robust.final - 1, seed, wider)
            self._machines, self.calm = among(own, scenario, self._loop)
        else:
            self.calm = np.zeros(1, int)  # the machines that are under no stress
        self._allowed, self._tighter = self._ensemble, 1.0
        if self._robust and self._allowed and not final:
            self._ensemble = self._allowed.tighter(self._robust.tighter)
            self._tighter = self._robust.tighter
        #: Whether there is but one machine in one motion, which may end early.
        self._single = not self._ensemble and len(self._samples) == 1 and not self._loop.doubled
        #: Individuals and machines of a generation.
        self._lanes = scenario.search.population * (self._robust.first if self._robust else 1)
        self._record = design.controller
        self._margins = _asked(scenario, self._loop, self.genome, final)
        self.simulated = 0  # samples of control of all that were ranked, without derivatives

    def rank_on(self, population: Population, machines: Integers, at_once: int = 0) -> Floats:
        """What they are ranked by on some of the machines that were drawn.

        ``at_once`` pairs of an individual and a machine are simulated together, or all.
        """
        gains = self.genome.gains(population)
        judged = self._eased(gains, machines, at_once)
        return self._rank(judged, self._ensemble, beside=self._beside(gains))[:, 0]

    def _ranked(
        self,
        population: Population,
        machines: Integers,
        penalty: float | None = None,
        needed: Floats | None = None,
        beside: Floats | None = None,
    ) -> Floats:
        """(n, 2) rank with broken constraints below all others, and with them weighed.

        On all ``machines``; on the first ``FEW`` alone who cannot reach what is ``needed``.
        """
        gains, ensemble = self.genome.gains(population), self._ensemble
        beside = self._beside(gains) if beside is None else beside
        if needed is None or ensemble is None or penalty is not None or len(machines) <= FEW:
            judged = self._eased(gains, machines)
            return self._rank(judged, ensemble, penalty, beside)
        some = self._eased(gains, machines[:FEW])
        reach = ensemble.reach(some, len(machines), beside)
        alive = np.flatnonzero((reach >= needed) | np.isclose(reach, needed, rtol=SLACK, atol=0.0))
        rank = np.stack([reach, reach], axis=1)
        if len(alive):
            own, rest = self.genome.gains(taken(population, alive)), machines[FEW:]
            more = self._eased(own, rest, len(needed) * FEW)
            pairs = zip(some, more, strict=True)
            whole = (np.concatenate([one[alive], other], axis=1) for one, other in pairs)
            rank[alive] = self._rank(Judged(*whole), ensemble, beside=beside[alive])
        return rank

    def _alone(self, population: Population, needed: Floats | None) -> Floats:
        """As ``_ranked`` on one machine in one motion, which ends for whoever is lost."""
        least = np.full(len(population.tree), -np.inf) if needed is None else needed
        gains, (samples,) = self.genome.gains(population), self._samples
        about = (self._loop, self._machines, samples, gains, least, self._dtype, self._lanes)
        judged, simulated = simulate.scores_needed(*about)
        self.simulated += int(simulated.sum())
        return self._rank(judged, None)

    def _eased(self, gains: Gains, machines: Integers, at_once: int = 0) -> Judged:
        """What individuals do on some of the machines.

        Of constraints a search allows those under a stress as much as the scenario does.
        """
        found = self._judged(gains, self._machines.take(machines), at_once)
        stressed = ~np.isin(machines, self.calm)
        if self._ensemble is None or self._tighter == 1.0 or not stressed.any():
            return found
        values, count = np.array(found.values), len(self._ensemble.constraints)
        values[:, stressed, :, values.shape[-1] - count :] /= self._tighter
        return found._replace(values=values)

    def _judged(self, gains: Gains, machines: Machines, at_once: int = 0) -> Judged:
        found = simulate.scores(
            self._loop, machines, self._samples, gains, self._dtype, at_once=at_once
        )
        self.simulated += found.merit[..., 0].size * sum(len(x.time) for x in self._samples)
        return found

    def _beside(self, gains: Gains) -> Floats:
        """(n,) by how much individuals break what is asked of the margins of their loops."""
        return self._margins.broken(gains) if self._margins else np.zeros(trailing(gains))

    def _rank(
        self,
        judged: Judged,
        ensemble: Ensemble | None,
        penalty: float | None = None,
        beside: Floats | float = 0.0,
    ) -> Floats:
        if ensemble is None:
            return np.stack(2 * [np.asarray(judged.rank[:, 0, 0])], axis=1)
        found = ensemble.verdict(judged, penalty, beside)
        return np.stack([found.rank, found.weighed], axis=1)

    @property
    def parts(self) -> Parts:
        """What is simulated."""
        return Parts(self._loop, self._machines, self._samples, self._ensemble)

    @property
    def has_derivative(self) -> bool:
        """Whether there is one axis to follow, so that its error has a derivative."""
        return len(self._loop.machine.axes) == 1

    def _linear(self, individual: Population, chosen: Integers | None = None) -> Linear | None:
        """The tracking error about one individual; None where it cannot be differentiated."""
        gains = self.genome.gains(individual)
        about = (self._loop, self._machines, *self._samples, gains, self._dtype, chosen)
        error, jacobian = simulate.error_jacobian(*about)
        finite = np.isfinite(error).all() and np.isfinite(jacobian).all()
        return Linear(error, jacobian, chosen) if finite else None

    def largest_signals(self, individual: Population) -> dict[str, float]:
        """What each signal of the first axis reaches at most, on the nominal machine."""
        gains = self.genome.gains(individual)
        return simulate.largest_signals(self._loop, self._machines, self._samples, gains)


def _asked(scenario: Scenario, loop: Loop, genome: Any, final: bool) -> AskedMargins | None:
    """What is asked of the loop, linearised, of finalists ``final``; None: nothing.

    Of a robust scenario at least that it is stable, where that can be told of such laws.
    """
    if not scenario.margins and not scenario.robust:
        return None
    with suppress(*[UserError] * (not scenario.margins)):
        found = AskedMargins(scenario, loop, _rubbing(scenario), final)
        found.broken(genome.gains(genome.empty()))
        return found
    return None


def _rubbing(scenario: Scenario) -> Machines | None:
    """Machines within the tolerances with the friction of the stress; None: none is asked for."""
    if not (scenario.robust and scenario.margins) or scenario.stress.friction <= 1.0:
        return None
    some = drawn_for(scenario, RUBBING, 0)
    return rubbing(scenario, some, Applied(friction=scenario.stress.friction))


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
