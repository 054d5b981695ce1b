"""Motions that diverge: repetition in finer steps, and when and why a motion diverged."""

from collections.abc import Callable, Iterable, Iterator
from typing import NamedTuple, TypeVar

import numpy as np

from hfc_design.core.numbers import Floats, Integers
from hfc_design.core.records import UserError
from hfc_design.files.scenario import Scenario
from hfc_design.motion.samples import MAX_SUBSTEPS
from hfc_design.simulation import memory

Result = TypeVar("Result")
#: Factors on the substeps with which a diverging motion is simulated again, in turn.
FINER = (4, 16)
#: A quantity has run away once it stays beyond this many times its median.
RUNAWAY = 1e3
#: The cause of a divergence in which all recorded quantities stay bounded.
FITNESS = "the fitness"


class Divergence(NamedTuple):
    """The quantity that diverged first, and when."""

    time_s: float
    cause: str  # a state of the machine, the command, or the fitness

    def __str__(self) -> str:
        if self.cause == FITNESS:
            return f"{FITNESS} is not a number"
        return f"{self.cause} runs away at {self.time_s:.4g} s"


def refined(
    scenario: Scenario,
    count: int,
    simulate: Callable[[Scenario, Integers], Iterable[Result]],
    diverged: Callable[[Result], bool],
    merged: Callable[[Result, Result], Result] = lambda before, after: after,
) -> list[Result]:
    """Return the results of ``count`` simulations; those that diverge are repeated in finer steps.

    ``simulate(scenario, indices)`` returns a result for each index, in their order; ``merged``
    combines a result with its repetition in finer steps.
    """
    results: list[Result] = [*simulate(scenario, np.arange(count))]
    for where in finer(scenario):
        waiting = np.flatnonzero([diverged(result) for result in results])
        if not len(waiting):
            break
        for k, again in zip(waiting.tolist(), simulate(where, waiting), strict=True):
            results[k] = merged(results[k], again)
    return results


def finer(scenario: Scenario) -> Iterator[Scenario]:
    """Yield the scenario in finer and finer steps, as far as allowed and as memory suffices."""
    for factor in FINER:
        substeps = factor * scenario.simulation.substeps
        simulation = scenario.simulation.model_copy(update={"substeps": substeps})
        refined = scenario.model_copy(update={"simulation": simulation})
        try:
            memory.check(scenario.name, memory.of_motion(refined))
        except UserError:
            return
        if substeps > MAX_SUBSTEPS:
            return
        yield refined


def divergence_of(time: Floats, motion: dict[str, Floats]) -> Divergence:
    """Return the quantity that diverged first in a motion.

    ``motion`` has each quantity by name, (steps,). Among quantities that diverge at the same sample
    it is the one that had grown most. If none diverges, the fitness is not a number, or the very
    last step diverged, whose result is not recorded: then the cause is ``FITNESS``.
    """
    candidates = [(*_runs_away(values), name) for name, values in motion.items()]
    since, _, cause = min(candidates, key=lambda item: item[:2])
    if since == len(time):
        cause = FITNESS
    step = time[1] - time[0] if len(time) > 1 else 0.0
    return Divergence(float(time[0] + since * step), cause)


@np.errstate(all="ignore")
def _runs_away(values: Floats) -> tuple[int, float]:
    """Return the sample from which values run away (their count: never), and minus their growth."""
    size = np.abs(values)
    finite = np.isfinite(size)
    usual = float(np.median(size[finite])) if finite.any() else 0.0
    bounded = finite & (size <= (RUNAWAY * usual or np.inf))
    since = len(bounded) - int(np.argmax(bounded[::-1])) if bounded.any() else 0
    return since, -float(size[since - 1] / usual) if since and usual else 0.0
