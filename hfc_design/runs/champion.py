"""Which individual of a search becomes its design."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from hfc_design.controllers.genome import Population, joined, taken
from hfc_design.core.records import RunError
from hfc_design.files.design import Design
from hfc_design.files.scenario import Scenario
from hfc_design.runs.individuals import design_of, with_score
from hfc_design.runs.problem import BEHIND, final_problem
from hfc_design.search.loop import Search
from hfc_design.simulation.evaluating import Evaluation, evaluate

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


def champion(
    search: Search, scenario: Scenario, one: Population | None = None
) -> tuple[Design, Evaluation]:
    """Design and evaluation of ``best_of``; RunError: all have diverged."""
    return next(best_of(search, scenario, one))[1:]


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
        each = zip(some, designs, strict=True)
        found = ((own, design, evaluate(design, scenario)) for own, design in each)  # one at a time
        individual, design, evaluation = max(found, key=lambda item: item[2].worth)
        if evaluation.diverged and k == 0:
            why = f" ({evaluation.divergence})" if evaluation.divergence else ""
            raise RunError(f"no design: the best {len(designs)} diverge in float64{why}; {HINTS}")
        design = with_score(design, evaluation, scenario)
        if not sound:
            design = design.model_copy(update={"score": {**design.score, LEAST_VIOLATED: True}})
        yield individual, design, evaluation


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
    found = []
    sources: list[Any] = [search.archive]
    if {"population", "score"} <= set(getattr(search.state, "_fields", ())):
        sources.append(search.state)
    for source in sources:
        order = np.argsort(-source.score, kind="stable")[:FINALISTS]
        ranked = order[np.isfinite(source.score[order])]
        found += [taken(source.population, np.array([k])) for k in ranked]
    trail = getattr(search.state, "trail", None)
    if trail is not None:  # whatever they were worth on a few machines
        found += [taken(trail, np.array([k])) for k in range(len(trail.tree))]
    return found
