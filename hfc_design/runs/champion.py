"""Choice of the individual of a search that becomes its design, and of whether to search again.

A search is repeated in *laps*, each on other machines, until a design is usable. Each lap starts
anew: to start from the design of the previous lap did not make it usable more often. Each lap has a
checkpoint, so that a stopped and resumed run ends with the same result as an uninterrupted one.
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

#: Number of the archive's best that are simulated again in float64 before one is chosen.
FINALISTS = 16
#: Largest number of these that take the *trial*, a test of usability, if there are many machines.
TRIED = 3
#: Advice if a search found no design whose simulation stays finite.
HINTS = (
    "try a larger simulation.substeps or search.population, smaller gains or ranges, a shorter "
    "simulation.duration_s, another run.seed or start"
)
SPREAD_HINT = "try a smaller robust.spread; "
#: Key in the score of a design that violates the constraints least, if none meets them.
LEAST_VIOLATED = "least_violated"
#: Key in the score of a design for the number of the lap that found it, if not the first.
LAP = "lap"
#: Offset of the seed of each lap from that of the previous one.
BEYOND = 2**34
#: Offset of the seed of the trial's machines from the seed of the run.
TRIAL = 2**40


class Lap(NamedTuple):
    """A finished search, and the evaluation of its design."""

    number: int  # from 0
    search: Search
    finalist: tuple[Population, Design, Evaluation]
    front: Front | None
    trial: Usable | None = None  # on machines of the trial, the same for all laps
    answer: Usable | None = None  # on the unseen machines; None: the trial did not end with yes

    @property
    def use(self) -> Usable | None:
        """Result of the last test of usability."""
        return self.answer or self.trial

    @property
    def rank(self) -> tuple[int, float, float]:
        """Sort key: the answer of the last test, the share of machines that pass, the merit."""
        assert self.use is not None
        verdict = (NO, ON_THIS_MODEL, YES).index(self.use.verdict)
        return verdict, float(self.use.good.mean()), self.finalist[2].worth


def laps(scenario: Scenario) -> int:
    """Return the largest number of laps: 1 if the scenario is not robust, or asks for a front."""
    return scenario.run.extend if scenario.robust and not scenario.traded else 1


def lap_of(scenario: Scenario, number: int) -> Scenario:
    """Return the scenario with the seed of a lap."""
    run = scenario.run.model_copy(update={"seed": scenario.run.seed + number * BEYOND})
    return scenario.model_copy(update={"run": run})


def lap_file(name: str, number: int) -> str:
    """Return the name of a file in a lap, given its name in the first lap."""
    stem, dot, rest = name.partition(".")
    return f"{stem}-{number + 1}{dot}{rest}" if number else name


def tried_lap(scenario: Scenario, number: int, search: Search, front: Front | None) -> Lap:
    """Return a lap with the first of its best designs that passes the trial, or else the best one.

    A design that passes is then tested on the unseen machines.

    Raises:
        RunError: all designs diverged.
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
    """Yield the best finalist (or the given ``one``), its design and its evaluation in float64.

    With several machines the next best follow, up to ``TRIED`` in all. With one machine the best is
    that with the largest ``worth``: float32 and a single simulation overrate nearly chaotic loops.

    Raises:
        RunError: all individuals diverged.
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
        evaluated = ((x, y, evaluate(y, scenario)) for x, y in pairs)  # one at a time
        individual, design, evaluation = max(evaluated, key=lambda item: item[2].worth)
        if evaluation.diverged and k == 0:
            why = f" ({evaluation.divergence})" if evaluation.divergence else ""
            raise RunError(f"no design: the best {len(designs)} diverge in float64{why}; {HINTS}")
        design = with_score(design, evaluation, scenario)
        yield individual, design if sound else noted(design, {LEAST_VIOLATED: True}), evaluation


def _in_turn(finalists: Population, scenario: Scenario) -> list[tuple[list[Population], bool]]:
    """Return finalists, the best first, each with True if most machines meet all constraints."""
    rank = final_problem(scenario).rank_of_finalists(finalists)
    sound = rank > -0.5 * BEHIND  # if none is sound, the best one is returned
    first = np.argsort(-rank, kind="stable")[: np.clip(sound.sum(), 1, TRIED)]
    return [([taken(finalists, np.array([k]))], bool(sound[k])) for k in first]


def _why(search: Search, scenario: Scenario) -> str:
    """Return why an individual of a completely diverged population diverges; "" if unknown."""
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
    """Return the best of the archive and of the last generation that did not fail, and a trail."""
    finalists = []
    sources: list[Any] = [search.archive]
    if {"population", "score"} <= set(getattr(search.state, "_fields", ())):
        sources.append(search.state)
    for source in sources:
        order = np.argsort(-source.score, kind="stable")[:FINALISTS]
        ranked = order[np.isfinite(source.score[order])]
        finalists += [taken(source.population, np.array([k])) for k in ranked]
    trail = getattr(search.state, "trail", None)
    if trail is not None:  # all of them: on few machines, scores say little
        finalists += [taken(trail, np.array([k])) for k in range(len(trail.tree))]
    return finalists
