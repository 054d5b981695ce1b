"""Every method as a generator: it yields candidates and is sent what they are worth.

So twenty-five seeds of one can go side by side, and all of their candidates are one population.
"""

from collections.abc import Callable, Generator
from typing import Any, NamedTuple

import numpy as np

from experiments.search_power.charts import Chart, charts_about, charts_of_stage, first
from experiments.search_power.optimizers import FAILED, Make, Optimizer
from experiments.search_power.tasks import Field, Ledger, When
from hfc_design.controllers.genome import Population, taken
from hfc_design.core.numbers import Floats, Integers
from hfc_design.search.loop import searcher


class Asked(NamedTuple):
    """Candidates of one seed."""

    population: Population
    when: When
    needed: Floats | None = None
    #: What the search would give now, the first of them first; None: the best it was told of.
    incumbent: Population | None = None
    #: Numbers of machines that are hard; who names some is scored alone.
    hard: Integers | None = None


#: Individuals that a strategy which keeps many would choose from in the end.
KEPT = 16
#: Gets scores (n,), -inf of what failed.
Search = Generator[Asked, Floats, None]


class Setup(NamedTuple):
    """How a peer is set up."""

    make: Make
    samples: int  # candidates of a round
    step: float  # factor on the first standard deviation of the genome
    islands: int = 4  # structures that compete
    alone: float = 0.5  # share of the budget from which on there is but one of them
    informed: bool = True  # begins with what is known of the machine
    fresh: bool = False  # compares within a round only, so that each may meet other machines
    restarts: bool = False  # small and large populations in turn (BIPOP)


def peer(setup: Setup, field: Field, ledger: Ledger, seed: int) -> Search:
    """A peer through the stages of the genome, or from first individuals on every structure."""
    genome, rng = field.problem.genome, np.random.default_rng(seed)
    if not genome.stages:
        population = first(genome, setup.informed, rng)
        score = yield Asked(population, When())
        charts = charts_about(genome, population, score, setup.islands)
        yield from halving(setup, field, ledger, charts, (0.0, 1.0), seed)
        return
    about, begun, total = None, 0.0, sum(share for share, _ in genome.stages)
    for number, (share, competing) in enumerate(genome.stages):
        islands = min(setup.islands, genome.structures) if competing else 1
        charts = charts_of_stage(genome, number, about, islands, rng)
        ends = (begun, begun + share / total)
        found = yield from halving(setup, field, ledger, charts, ends, seed + 1000 * number)
        about, begun = found or about, ends[1]


def halving(
    setup: Setup,
    field: Field,
    ledger: Ledger,
    charts: list[Chart],
    ends: tuple[float, float],
    seed: int,
) -> Generator[Asked, Floats, Population | None]:
    """An optimizer on each chart, in turn, of which the better half remains, then one.

    Gives the incumbent of the last one.
    """
    islands = [Island(setup, chart, seed + k) for k, chart in enumerate(charts)]
    heats = int(np.ceil(np.log2(max(len(islands), 1))))
    turn = 0
    while islands:
        share = ledger.samples / field.budget
        within = (share - ends[0]) / (ends[1] - ends[0])
        if within >= 1.0:
            break
        room = len(charts) / 2 ** int(within / setup.alone * heats) if heats else 1
        if len(islands) > max(room, 1):
            order = np.argsort([-one.worth for one in islands], kind="stable")
            islands = [islands[k] for k in order[: max(int(np.ceil(room)), 1)]]
        one = islands[turn % len(islands)]
        turn += 1
        when = When("fresh" if setup.fresh else "fixed", share)
        population = one.asked(within)
        best = max(islands, key=lambda island: island.worth)
        score = yield Asked(population, when, incumbent=best.incumbent)
        one.told(score)
    return max(islands, key=lambda island: island.worth).incumbent if islands else None


class Island:
    """An optimizer on a chart, begun anew where it comes to rest."""

    def __init__(self, setup: Setup, chart: Chart, seed: int):
        self.setup, self.chart, self.seed = setup, chart, 7919 * seed + 1
        self.rng = np.random.default_rng(self.seed)
        self.worth, self.best = -np.inf, np.zeros(chart.size)
        self.large, self.small, self.spent = 0, 0, {True: 0, False: 0}
        self.is_large = True
        self.optimizer = self._made(setup.samples, setup.step * chart.step)

    def _made(self, samples: int, step: float) -> Optimizer:
        self.seed += 1
        return self.setup.make(self.chart, step, samples, self.seed % 2**31)

    def asked(self, within: float) -> Population:
        """Candidates, ``within`` the share of its time that has passed."""
        if self.optimizer.done:
            self._anew()
        if hasattr(self.optimizer, "share"):
            self.optimizer.share = within
        self.points = self.optimizer.ask()
        return self.chart.members(self.points)

    def told(self, score: Floats) -> None:
        """What they are worth."""
        costs = np.where(np.isfinite(score), -score, FAILED)
        self.optimizer.tell(self.points, costs)
        self.spent[self.is_large] += len(score)
        own = float(score.max())
        if self.setup.fresh:  # of machines that are others each time the last word counts
            self.worth = own if not np.isfinite(self.worth) else 0.8 * self.worth + 0.2 * own
            self.best = self.points[int(np.argmax(score))]
        elif own > self.worth:
            self.worth, self.best = own, self.points[int(np.argmax(score))]

    @property
    def incumbent(self) -> Population | None:
        """The mean of its distribution, or the best that it has seen."""
        mean = self.optimizer.incumbent if self.setup.fresh else None
        return self.chart.members((self.best if mean is None else mean)[None])

    def _anew(self) -> None:
        """BIPOP (Hansen, BBOB 2009): twice the population, or a small one with a small step."""
        base, step = self.setup.samples, self.setup.step * self.chart.step
        if not self.setup.restarts:
            self.optimizer = self._made(base, step)
            return
        self.is_large = self.spent[True] <= self.spent[False]
        if self.is_large:
            self.large += 1
            samples = base * 2**self.large
        else:
            largest = base * 2**self.large
            samples = int(base * (0.5 * largest / base) ** (self.rng.random() ** 2))
            step *= 10.0 ** (-2.0 * self.rng.random())
        self.optimizer = self._made(max(samples, base), step)


def strategy(settings: Any, field: Field, ledger: Ledger, seed: int) -> Search:
    """A strategy of this project, as ``search.loop.generations`` runs it."""
    problem = field.of_strategy(settings).of_seed(ledger)
    own = searcher(settings, problem.task)
    state: Any = None
    for generation in range(settings.generations):
        rng = np.random.default_rng([seed, generation])
        if generation == 0:
            state, asked = own.start(rng)
        else:
            state, asked = own.ask(state, generation, rng)
        when = When("own", generation=generation)
        needed = getattr(asked, "needed", None)
        hard = getattr(asked, "machines", None)
        score = yield Asked(asked.population, when, needed, _incumbent(state), hard)
        state = own.tell(state, asked, np.where(np.isfinite(score), score, -np.inf))


def _incumbent(state: Any) -> Population | None:
    """The best that it keeps, which may be means."""
    if state is None or not hasattr(state, "score"):
        return None
    count = 1 if hasattr(state, "trail") else KEPT
    return taken(state.population, np.argsort(-state.score, kind="stable")[:count])


#: Of a field, the ledger of a seed and its number.
Method = Callable[[Field, Ledger, int], Search]
