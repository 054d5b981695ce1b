"""Definition of a stable machine: its motion settles, and the drive controls it.

On every machine

- the motion is finite,
- a copy with slightly shifted initial positions ends on the same motion (``unsettled.py``): there
  is no limit cycle, and nothing grows,
- no drive stands at a limit of its command for more than a tenth of the last quarter,
- the error of the last quarter is within ``MULTIPLE`` times that of the nominal machine or within
  a tolerance, whichever is larger, and never beyond the largest reference. The tolerance is the
  scenario's constraint on ``late_error``, else ``TOLERANCE`` of the largest reference. If the
  nominal machine does not settle, only the tolerance counts. A reference of 0 gives no bound.
"""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from hfc_design.core.numbers import SAME_SINGLE, Floats, Mask
from hfc_design.files.scenario import Scenario
from hfc_design.objectives.constraints import constraints_on
from hfc_design.objectives.metric import Metric
from hfc_design.objectives.metrics import RUNNING
from hfc_design.simulation.closed_loop import Loop

#: Metrics that ``instabilities`` needs, in the order in which it reads them.
STABILITY = tuple(RUNNING[name] for name in ("unsettled", "limit_share", "late_error"))
#: Largest share of a small disturbance of the start that may still oscillate at the end.
UNSETTLED = 0.3
#: A drive that stands at a limit for a larger share of the last quarter no longer controls.
LIMITED = 0.1
MULTIPLE = 3.0
TOLERANCE = 0.05
#: Reasons of ``instabilities``, each with an explanation.
EXPLAINED = {
    "diverges": "The motion grows without bound.",
    "stays at a limit": "In the last quarter of the motion the command is at a limit of the "
    f"drive for more than {100 * LIMITED:g} % of the time, so the loop is "
    "not controlled.",
    "oscillates": "A copy with a slightly different initial state does not return to the "
    f"same motion: at the end more than {100 * UNSETTLED:g} % of the "
    "disturbance is left, as in a limit cycle.",
    "is far off": f"In the last quarter the error is more than {MULTIPLE:g} times that of the "
    "nominal machine and above the scenario’s constraint on late_error "
    f"(without one, above {100 * TOLERANCE:g} % of the largest reference), or "
    "it is larger than the reference itself.",
}


def measuring(loop: Loop, measures: Iterable[Metric] = ()) -> Loop:
    """Return the loop with more metrics: ``measures``, then those that ``instabilities`` needs."""
    judge = loop.judge
    return loop._replace(judge=judge._replace(measured=(*judge.measured, *measures, *STABILITY)))


def instabilities(measured: Floats, failed: Mask, motions: Sequence[Scenario]) -> dict[str, Mask]:
    """Return for each reason not to be stable where it applies: text -> (machines, motions).

    ``measured`` (machines, motions, values) ends with ``STABILITY``; ``motions`` are scenarios of
    one motion each. The nominal machine is the first; no reason applies to a stable machine.
    """
    unsettled, limited, late = np.moveaxis(measured[..., -len(STABILITY) :], -1, 0)
    axes = len(motions[0].plant.machine.axes)  # the share is a mean over axes, the limit for each
    swings = ~(unsettled <= UNSETTLED)
    saturated = ~(limited <= LIMITED / axes * (1.0 + SAME_SINGLE))
    settles, off = ~(failed | swings | saturated), np.ones_like(failed)
    for k, motion in enumerate(motions):
        largest = largest_reference(motion)
        off[0, k] = not late[0, k] <= largest
        multiple = MULTIPLE * late[0, k] if settles[0, k] and not off[0, k] else 0.0
        most = min(max(multiple, _tolerance(motion, largest)), largest)
        off[1:, k] = ~(late[1:, k] <= most)
    others = {"stays at a limit": saturated, "oscillates": swings, "is far off": off}
    return {"diverges": failed} | {why: mask & ~failed for why, mask in others.items()}


def reasons_text(reasons: Mapping[str, int]) -> str:
    """Return the number of machines for each reason as a text, most frequent first; "": none."""
    ranked = sorted(reasons.items(), key=lambda item: -item[1])
    return ", ".join(counted(count, why) for why, count in ranked)


def counted(count: int, reason: str) -> str:
    """Return the text of a number of machines and a ``reason``, whose verb agrees with it."""
    verb, blank, rest = reason.partition(" ")
    several = ("are" if verb == "is" else verb.removesuffix("s")) + blank + rest
    return f"{count} {reason if count == 1 else several}"


def largest_reference(motion: Scenario) -> float:
    """Return the largest distance of any axis from its start in a motion; inf if none moves."""
    each = zip(motion.samples().axes, motion.places.values(), strict=True)
    largest = max(float(np.abs(axis.reference - place).max()) for axis, place in each)
    return largest * (1.0 + SAME_SINGLE) or np.inf  # an axis that never moves is off by this


def _tolerance(motion: Scenario, largest: float) -> float:
    bounds = constraints_on(motion.constraints, motion.units)
    late_bounds = [bound.most for bound in bounds if bound.metric.name == "late_error"]
    return late_bounds[0] if late_bounds else TOLERANCE * largest
