"""Which individual of a search becomes its design, and whether another search is to follow.

A search goes on in laps, each on other machines, until a design is usable. Each lap starts
elsewhere: one that went on from the design of the last has not mended it more often. Each has a
checkpoint: a stopped run ends as one that was not.
"""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from hfc_design.controllers.genome import Population, joined, taken
from hfc_design.core.records import RunError
from hfc_design.files.design import Design
from hfc_design.files.scenario import Scenario
from hfc_design.runs.front import Front
from hfc_design.runs.individuals import design_of, noted, with_score
from hfc_design.runs.problem import BEHIND, final_problem
from hfc_design.search.loop import Search
from hfc_design.simulation.acceptance import NO, ON_THIS_MODEL, YES, Usable
from hfc_design.simulation.evaluating import Evaluation, evaluate
from hfc_design.simulation.usable import usable

#: This many of the archive's best are simulated again in float64 before one is chosen.
FINALISTS = 16
#: So many of those on many machines may stand the trial.
TRIED = 3
#: What to try where a search found nothing that stays finite.
HINTS = (
    "try a larger simulation.substeps or search.population, smaller gains or ranges, a shorter "
    "simulation.duration_s, another run.seed or start"
)
SPREAD_HINT = "try a smaller robust.spread; "
#: In the score of a design that violates the constraints least; none that was tried meets them.
LEAST_VIOLATED = "least_violated"
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
    finalist: tuple[Population, Design, Evaluation]
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
        verdict = (NO, ON_THIS_MODEL, YES).index(self.use.verdict)
        return verdict, float(self.use.good.mean()), self.finalist[2].worth


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


def tried_lap(scenario: Scenario, number: int, search: Search, front: Front | None) -> Lap:
    """A lap with the first of its best designs that stands the trial, or the nearest to it.

    Of one that does the answer is asked.

    Raises:
        RunError: all have diverged.
    """
    one = front.individual(search, front.best) if front and len(front.merit) else None
    best: Lap | None = None
    seed = scenario.run.seed + TRIAL
    for finalist in best_of(search, scenario, one):
        use = usable(finalist[1], scenario, seed=seed) if laps(scenario) > 1 else None
        lap = Lap(number, search, finalist, front, use)
        best = lap if best is None or lap.rank > best.rank else best
        if use is None or use.yes:
            break
    assert best is not None
    stood = best.trial is not None and best.trial.yes
    return best._replace(answer=usable(best.finalist[1], scenario)) if stood else best


def best_of(
    search: Search, scenario: Scenario, one: Population | None = None
) -> Iterator[tuple[Population, Design, Evaluation]]:
    """The best of the archive and of the last generation in float64, or that ``one``.

    On many machines the next best follow, ``TRIED`` in all. float32 and a single try flatter loops
    that are nearly chaotic: of one machine each is ranked by its ``worth``.

    Raises:
        RunError: all have diverged.
    """
    finalists = _finalists(search) if one is None else [one]
    if not finalists:
        tried = f"every individual diverged{_why(search, scenario)}"
        raise RunError(f"no design: {tried}; {SPREAD_HINT if scenario.robust else ''}{HINTS}")
    many = scenario.ensemble and one is None
    tries = _in_turn(joined(*finalists), scenario) if many else [(finalists, True)]
    for k, (some, sound) in enumerate(tries):
        designs = [design_of(individual, scenario) for individual in some]
        pairs = zip(some, designs, strict=True)
        evaluated = (
            (x, design, evaluate(design, scenario)) for x, design in pairs
        )  # one at a time
        individual, design, evaluation = max(evaluated, key=lambda item: item[2].worth)
        if evaluation.diverged and k == 0:
            why = f" ({evaluation.divergence})" if evaluation.divergence else ""
            raise RunError(f"no design: the best {len(designs)} diverge in float64{why}; {HINTS}")
        design = with_score(design, evaluation, scenario)
        yield individual, design if sound else noted(design, {LEAST_VIOLATED: True}), evaluation


def _in_turn(finalists: Population, scenario: Scenario) -> list[tuple[list[Population], bool]]:
    """Those that rank first within the tolerances, and whether most machines keep everything."""
    rank = final_problem(scenario).rank_of_finalists(finalists)
    sound = rank > -0.5 * BEHIND  # of others the one that breaks least is enough
    first = np.argsort(-rank, kind="stable")[: np.clip(sound.sum(), 1, TRIED)]
    return [([taken(finalists, np.array([k]))], bool(sound[k])) for k in first]


def _why(search: Search, scenario: Scenario) -> str:
    """Why one of a population diverges that has all diverged; "" if nobody knows."""
    population = getattr(search.state, "population", None)
    if population is None:
        return ""
    lost = evaluate(design_of(taken(population, np.array([0])), scenario), scenario)
    if lost.divergence is None:
        finer = lost.substeps > scenario.simulation.substeps
        other = f"with simulation.substeps = {lost.substeps}" if finer else "in float64"
        return f" (one does not {other})"
    return f" ({lost.divergence})"


def _finalists(search: Search) -> list[Population]:
    """The best of the archive and of the last generation, without those that failed."""
    finalists = []
    sources: list[Any] = [search.archive]
    if {"population", "score"} <= set(getattr(search.state, "_fields", ())):
        sources.append(search.state)
    for source in sources:
        order = np.argsort(-source.score, kind="stable")[:FINALISTS]
        ranked = order[np.isfinite(source.score[order])]
        finalists += [taken(source.population, np.array([k])) for k in ranked]
    trail = getattr(search.state, "trail", None)
    if trail is not None:  # whatever they were worth on a few machines
        finalists += [taken(trail, np.array([k])) for k in range(len(trail.tree))]
    return finalists
