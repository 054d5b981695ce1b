"""A search that goes on: laps, each on other machines, until one is usable.

Each starts elsewhere: one that went on from the design of the last has not mended it more often.
Each has a checkpoint: a stopped run ends as one that was not.
"""

from typing import NamedTuple

from hfc_design.controllers.genome import Population
from hfc_design.files.design import Design
from hfc_design.files.scenario import Scenario
from hfc_design.runs.front import Front
from hfc_design.search.loop import Search
from hfc_design.simulation.evaluating import Evaluation
from hfc_design.simulation.in_use import NO, ON_THIS_MODEL, YES, Usable

#: In the score of a design that a later lap has found: which.
LAP = "lap"
#: A lap is seeded so far beyond the one before.
BEYOND = 2**34
#: The machines of the trial are drawn with a seed so far beyond that of the run.
TRIAL = 2**40


class Lap(NamedTuple):
    """A finished search, and what its design is worth."""

    number: int  # from 0
    search: Search
    found: tuple[Population, Design, Evaluation]
    front: Front | None
    trial: Usable | None = None  # on machines of the trial, the same for all laps
    answer: Usable | None = None  # on others that are met once a lap; None: the trial is no yes

    @property
    def use(self) -> Usable | None:
        """What was asked last."""
        return self.answer or self.trial

    @property
    def rank(self) -> tuple[int, float, float]:
        """By what was asked last, then the share of the machines, then the merit."""
        assert self.use is not None
        stood = (NO, ON_THIS_MODEL, YES).index(self.use.verdict)
        return stood, float(self.use.good.mean()), self.found[2].worth


def laps(scenario: Scenario) -> int:
    """How many there may be: one of a search that has no answer, or looks for a front."""
    return scenario.run.extend if scenario.robust and not scenario.traded else 1


def lap_of(scenario: Scenario, number: int) -> Scenario:
    """The scenario as a lap has it."""
    run = scenario.run.model_copy(update={"seed": scenario.run.seed + number * BEYOND})
    return scenario.model_copy(update={"run": run})


def lap_file(name: str, number: int) -> str:
    """A file of a lap, by its name in the first one."""
    stem, dot, rest = name.partition(".")
    return f"{stem}-{number + 1}{dot}{rest}" if number else name
