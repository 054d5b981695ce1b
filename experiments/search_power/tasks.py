"""The tasks of the experiment, and what candidates of many searches at once are worth there."""

from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any, Literal, NamedTuple

import numpy as np

from hfc_design.controllers.genome import Population, taken
from hfc_design.core.numbers import Floats, Integers
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.scenario import Scenario
from hfc_design.runs.problem import Problem
from hfc_design.search.newton import Linear
from hfc_design.search.strategies.race import RaceSettings
from hfc_design.search.strategy import Task
from hfc_design.simulation import population as simulate
from hfc_design.simulation.compiled import filled_up

#: Wall time of a lane of a Jacobian over that of a lane of a population, measured by ``factor.py``.
TANGENT = 3.8
#: Populations are cut into blocks of one of these, so that few programs are compiled.
BLOCKS = (256, 512, 1024, 4096)
#: Machines on which searches compare that meet always the same ones.
FIXED = 24
#: Generations of a search whose scores are compared within a generation only: in each it meets
#: other machines, and what it may still break narrows down.
FINE = 100_000


class When(NamedTuple):
    """Which machines of a robust task are met."""

    #: "fixed": always the same ones; "fresh": others in each round, for searches that compare
    #: scores within a round only; "own": as the strategy of the scenario meets them.
    kind: Literal["fixed", "fresh", "own"] = "fixed"
    share: float = 0.0  # of the budget that is spent
    generation: int = 0


class Ground(NamedTuple):
    """A task: a scenario with changes, and how long every search may take."""

    name: str
    scenario: str
    changes: Mapping[str, Any]
    budget: int  # in individuals that are simulated to the end, of each seed


GROUNDS = {
    one.name: one
    for one in (
        Ground("ramp", "c-axis-ramp", {"limits.command": 250.0}, 40_000),
        Ground("cutting", "c-axis-ramp-cutting", {"limits.command": 250.0}, 40_000),
        Ground("practical", str(Path(__file__).parent / "results" / "practical.toml"), {}, 6_480),
        Ground("contour", "feed-drive-contour", {}, 8_000),
    )
}


@dataclass
class Ledger:
    """What one seed has spent, and the best it has seen by then."""

    samples: int = 0
    best: float = -np.inf
    #: (samples, best) whenever the best has changed; (samples, seconds) after each round.
    steps: list[tuple[int, float]] = field(default_factory=list)
    times: list[tuple[int, float]] = field(default_factory=list)

    def spend(self, samples: float) -> None:
        """So many samples of control were simulated."""
        self.samples += int(samples)

    def see(self, best: float) -> None:
        """Something was worth so much."""
        if best > self.best:
            self.best = float(best)
            self.steps.append((self.samples, self.best))


class Counted(Problem):
    """A problem whose samples stand in a ledger, those of first laws too."""

    def __init__(self, scenario: Scenario):
        super().__init__(scenario)
        self.ledger, self.own_genome = Ledger(), self.genome

    def of_seed(self, ledger: Ledger) -> "Counted":
        """The same with a ledger of its own."""
        found = copy(self)
        found.ledger = ledger
        return found

    def rank(
        self,
        population: Population,
        generation: int = 0,
        needed: Floats | None = None,
        hard: Integers | None = None,
    ) -> Floats:
        """As every problem ranks; laws are no candidates."""
        before = self.simulated
        found = super().rank(population, generation, needed, hard)
        self.ledger.spend(self.simulated - before)
        if self.genome is self.own_genome and len(found):
            self.ledger.see(found.max())
        return found

    @property
    def task(self) -> Task:
        """With Jacobians that are paid for."""
        task = super().task
        differ, hardest = task.linearised, task.hardest
        if hardest is not None:
            task = task._replace(hardest=self._counted(hardest))
        if differ is None:
            return task
        steps = len(self.motions[0].time)

        def paid(individual: Population, chosen: Integers) -> Linear | None:
            assert differ is not None
            self.ledger.spend(int(TANGENT * filled_up(chosen).size * steps))
            return differ(individual, chosen)

        return task._replace(linearised=paid)

    def _counted(self, hardest: Callable[..., Integers]) -> Callable[..., Integers]:
        """With the samples of those who are asked which machines are hard."""

        def found(*asked: Any) -> Integers:
            before = self.simulated
            machines = hardest(*asked)
            self.ledger.spend(self.simulated - before)
            return machines

        return found


class Field:
    """A ground to search on: candidates of any number of seeds are scored as one population."""

    def __init__(self, ground: Ground, changes: Mapping[str, Any] | None = None):
        self.ground = ground
        self.scenario = load_scenario(ground.scenario, {**ground.changes, **(changes or {})})
        self.problem = Counted(self.scenario)
        self.steps = sum(len(motion.time) for motion in self.problem.motions)
        robust = self.scenario.robust
        #: Samples of an individual that is simulated to the end.
        self.whole = self.steps * (robust.first if robust else 1)
        self.single = robust is None
        #: Seconds that first calls of compiled programs took.
        self.lost = 0.0
        self._known: set[object] = set()
        self._problems: dict[str, Problem] = {"own": self.problem}
        self._settings = self.scenario.search

    def of_strategy(self, settings: Any) -> Counted:
        """The problem as a strategy with these settings meets it.

        A race that is shorter looks for first laws for less long, for one.
        """
        if settings.preset != self.scenario.search.preset:
            return self.problem
        if settings != self._settings:
            changed = self.scenario.model_copy(update={"search": settings})
            self._settings, self._problems["own"] = settings, Counted(changed)
        found = self._problems["own"]
        assert isinstance(found, Counted)
        return found

    @property
    def budget(self) -> int:
        """Samples of control of each seed."""
        return self.ground.budget * self.whole

    def scored(
        self,
        population: Population,
        when: When,
        needed: Floats | None = None,
        hard: Integers | None = None,
    ) -> tuple[Floats, Floats]:
        """What everyone is worth, -inf where it failed, and the samples that it took."""
        count = len(population.tree)
        if not self.single:
            score = self._warm((when.kind, count), lambda: self._robust(population, when, hard))
            often = FIXED * self.steps if when.kind == "fixed" else self.whole
            return score, np.full(count, float(often))
        least = np.full(count, -np.inf) if needed is None else needed
        width = next((one for one in BLOCKS if one >= count), BLOCKS[-1])
        found = []
        for start in range(0, count, width):
            own = np.arange(start, min(start + width, count))
            lane = np.append(own, np.full(width - len(own), own[-1]))
            wanted = np.append(least[own], np.full(width - len(own), np.inf))
            block = taken(population, lane)
            judged = self._warm(width, partial(self._block, block, wanted))
            found.append([x[: len(own)] for x in judged])
        return tuple(np.concatenate(parts) for parts in zip(*found, strict=True))

    def _warm(self, program: object, run: Callable[[], Any]) -> Any:
        """What ``run`` gives; a program that is new runs once before, and that is not timed."""
        if program not in self._known:
            self._known.add(program)
            begun = perf_counter()
            run()
            self.lost += perf_counter() - begun
        return run()

    def _block(self, population: Population, needed: Floats) -> tuple[Floats, Floats]:
        loop, machines, (samples,) = self.problem.loop, self.problem.machines, self.problem.motions
        gains = self.problem.genome.gains(population)
        dtype = np.dtype(self.scenario.run.precision)
        judged, simulated = simulate.scores_needed(loop, machines, samples, gains, needed, dtype)
        return judged.rank[:, 0, 0], simulated

    def _robust(self, population: Population, when: When, hard: Integers | None) -> Floats:
        if when.kind not in self._problems:
            search, robust = self.scenario.search, self.scenario.robust
            assert robust is not None
            many = dict.fromkeys(("first", "machines", "elite"), FIXED)
            changes = {
                "fixed": {
                    "search": RaceSettings(population=search.population, stick_penalty=0.0),
                    "robust": robust.model_copy(update=many),
                },
                "fresh": {"search": search.model_copy(update={"generations": FINE})},
            }
            changed = self.scenario.model_copy(update=changes[when.kind])
            self._problems[when.kind] = Problem(changed)
        number = when.generation if when.kind == "own" else int(when.share * FINE)
        return self._problems[when.kind].rank(population, number, hard=hard)
