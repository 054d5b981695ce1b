"""A search that goes on: laps, each from another start and on other machines, until one is usable.

Each has a checkpoint of its own, and what decides of it follows from that, so that a run which was
stopped ends as one that was not.
"""

from typing import NamedTuple

from hfc_design.controllers.genome import Population
from hfc_design.files.design import Design
from hfc_design.files.scenario import Scenario
from hfc_design.runs.front import Front
from hfc_design.search.loop import Search
from hfc_design.simulation.evaluating import Evaluation
from hfc_design.simulation.in_use import NO, ON_THIS_MODEL, YES, Usable
from hfc_design.simulation.usable import usable

#: In the score of a design that a later lap has found: which.
LAP = "lap"
#: A lap is seeded so far beyond the one before; the machines that decide of it, that far more.
BEYOND, DECIDING = 2**34, 2**33


class Lap(NamedTuple):
    """A finished search, and what its design is worth."""

    number: int  # from 0
    search: Search
    found: tuple[Population, Design, Evaluation]
    front: Front | None
    use: Usable | None = None  # on machines that neither search nor answer meets

    @property
    def enough(self) -> bool:
        """Whether nobody has to go on."""
        return self.use is None or self.use.yes

    def decided(self, scenario: Scenario) -> "Lap":
        """The same with its use."""
        seed = lap_of(scenario, self.number).run.seed + DECIDING
        return self._replace(use=usable(self.found[1], scenario, seed=seed))

    def better_than(self, other: "Lap") -> bool:
        """By the answer, then the share of the machines, then the merit."""
        return self._rank > other._rank

    @property
    def _rank(self) -> tuple[int, float, float]:
        assert self.use is not None
        answer = (NO, ON_THIS_MODEL, YES).index(self.use.verdict)
        return answer, float(self.use.good.mean()), self.found[2].worth


def laps(scenario: Scenario) -> int:
    """How many there may be: one of a search that has no answer, or looks for a front."""
    return scenario.run.extend if scenario.robust and not scenario.traded else 1


def lap_of(scenario: Scenario, number: int) -> Scenario:
    """The scenario as a lap has it."""
    seed = scenario.run.seed + number * BEYOND
    return scenario.model_copy(update={"run": scenario.run.model_copy(update={"seed": seed})})


def lap_file(name: str, number: int) -> str:
    """A file of a lap, by its name in the first one."""
    stem, dot, rest = name.partition(".")
    return f"{stem}-{number + 1}{dot}{rest}" if number else name
