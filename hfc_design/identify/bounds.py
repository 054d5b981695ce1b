"""Parameters that ended at a bound: where a fit says less than a machine can have.

A friction that is not there has a logarithm that runs away; a break-away torque below the Coulomb
torque is no machine's. No interval that slopes tell is true there.
"""

import numpy as np

from hfc_design.core.numbers import Floats, Mask
from hfc_design.identify.certainty import Certainty
from hfc_design.identify.fit import VAGUE, Fit
from hfc_design.identify.free import Free
from hfc_design.identify.search import Found, held

#: A bound is found by halving the way to it so often.
HALVED = 50


def bounded(found: Found, known: Certainty, delayed: bool) -> tuple[Found, Mask]:
    """A fit that is a machine, and (names,) which parameters are at a bound for that.

    That is the one that is known least of those that can be blamed. A fit stays impossible if no
    single parameter can.
    """
    free, bound = found.fit.free, np.zeros(len(known.error), bool)
    for _ in bound:
        blamed = _blamed(found.fit, np.where(bound, np.inf, known.error))
        if blamed is None:
            break
        bound[blamed] = True
        numbers = _at_the_edge(free, found.fit.numbers, blamed)
        found = held(found, numbers, ~bound, delayed)
    if (blamed := _blamed(found.fit, np.where(bound, np.inf, known.error))) is not None:
        numbers = _at_the_edge(free, found.fit.numbers, blamed)  # the others moved a little
        found = found._replace(fit=found.fit._replace(numbers=numbers))
    return found, bound


def vanished(fit: Fit, known: Certainty) -> Mask:
    """(names,) what may be 0 and has come so near to it that its logarithm tells no more."""
    free = fit.free
    near = (free.positive > 0) & (fit.numbers[:-1] < -VAGUE) & ~np.array(known.told)
    may = [_possible(free, fit.numbers, {name: 0.0}) for name in free.names]
    return np.asarray(near & np.array(may))


def _possible(free: Free, numbers: Floats, changes: dict[str, float] | None = None) -> bool:
    told = dict(zip(free.names, map(float, free.values(numbers)), strict=True))
    whole = {name: float(x) for name, x in free.start._asdict().items()}
    return free.drive.fault(whole | told | (changes or {})) is None


def _blamed(fit: Fit, error: Floats) -> int | None:
    """The least known parameter with which, where it began, the others are a machine."""
    if _possible(fit.free, fit.numbers):
        return None
    for k in np.argsort(-error, kind="stable").tolist():
        numbers = fit.numbers.copy()
        numbers[k] = fit.free.begun[k]
        if _possible(fit.free, numbers):
            return int(k)
    return None


def _at_the_edge(free: Free, numbers: Floats, k: int) -> Floats:
    """The numbers with one of them as near to what it was as a machine can have it."""
    inside, outside = numbers.copy(), numbers.copy()
    inside[k] = free.begun[k]
    for _ in range(HALVED):
        middle = inside.copy()
        middle[k] = 0.5 * (inside[k] + outside[k])
        inside, outside = (middle, outside) if _possible(free, middle) else (inside, middle)
    return inside
