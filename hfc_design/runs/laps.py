"""A search that goes on: laps, each on other machines, until one is usable.

One whose scores are compared within a generation only goes on from the design of the last one, if
that passes on most machines, with more of them at once: a few do not tell what is missing. Behind
that, and where a stress breaks the design, the next one starts elsewhere: more of the stress has
hardly ever mended one. Each has a checkpoint: a stopped run ends as one that was not.
"""

from typing import NamedTuple

from hfc_design.controllers.genome import Population
from hfc_design.files.design import Design
from hfc_design.files.scenario import Scenario
from hfc_design.runs.front import Front
from hfc_design.search.loop import STRATEGIES, Search
from hfc_design.simulation.evaluating import Evaluation
from hfc_design.simulation.in_use import NO, ON_THIS_MODEL, YES, Usable

#: In the score of a design that a later lap has found: which.
LAP = "lap"
#: A lap is seeded so far beyond the one before.
BEYOND = 2**34
#: The machines of the trial are drawn with a seed so far beyond that of the run.
TRIAL = 2**40
#: A lap that goes on: so many times the machines for each candidate, so much fewer generations.
FINER = 4
#: Least share of the machines that are all right for it.
NEARLY = 0.9


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

    def goes_on(self, scenario: Scenario) -> bool:
        """Whether the next one begins with its design: a few machines are missing."""
        able, use = STRATEGIES.get(scenario.search.preset).forgets(scenario.search), self.use
        few = use is not None and use.verdict == NO and float(use.good.mean()) >= NEARLY
        return able > 0 and few

    @property
    def rank(self) -> tuple[int, float, float]:
        """By what was asked last, then the share of the machines, then the merit."""
        assert self.use is not None
        stood = (NO, ON_THIS_MODEL, YES).index(self.use.verdict)
        return stood, float(self.use.good.mean()), self.found[2].worth


def laps(scenario: Scenario) -> int:
    """How many there may be: one of a search that has no answer, or looks for a front."""
    return scenario.run.extend if scenario.robust and not scenario.traded else 1


def lap_of(scenario: Scenario, number: int, finer: bool = False) -> Scenario:
    """The scenario as a lap has it; with more machines and fewer generations where it goes on."""
    run = scenario.run.model_copy(update={"seed": scenario.run.seed + number * BEYOND})
    own = scenario.model_copy(update={"run": run})
    if not finer or own.robust is None:
        return own
    names = "first", "machines", "elite"
    more = {name: min(FINER * getattr(own.robust, name), own.robust.final) for name in names}
    fewer = {"generations": max(own.search.generations // FINER, 1)}
    changes = {"robust": own.robust.model_copy(update=more)}
    return own.model_copy(update=changes | {"search": own.search.model_copy(update=fewer)})


def lap_file(name: str, number: int) -> str:
    """A file of a lap, by its name in the first one."""
    stem, dot, rest = name.partition(".")
    return f"{stem}-{number + 1}{dot}{rest}" if number else name
