"""Parameters that ended at a bound: where a fit says less than a machine can have.

A friction that is not there has a logarithm that runs away; a break-away torque below the Coulomb
torque is no machine's. No interval that slopes tell is true there.
"""

import numpy as np

from hfc_design.core.numbers import Floats, Mask, digits
from hfc_design.identify.certainty import Certainty
from hfc_design.identify.fit import VAGUE, Fit
from hfc_design.identify.free import LOAD, Free
from hfc_design.identify.search import Found, held

#: The way to a bound is halved so often, and the others fitted again each time.
HALVED = 8
#: A logarithm that is 0 to all digits.
GONE = -60.0


def bounded(found: Found, known: Certainty) -> tuple[Found, Mask]:
    """A fit that is a machine, and (names,) which parameter is at a bound for that.

    That is the one that is known least of those that can be blamed. A fit stays impossible if no
    single parameter can.
    """
    bound = np.zeros(len(known.error), bool)
    if (k := _blamed(found.fit, known.error)) is None:
        return found, bound
    inside, outside = float(found.fit.free.begun[k]), float(found.fit.numbers[k])
    best: Found | None = None
    for _ in range(HALVED):
        numbers = found.fit.numbers.copy()
        numbers[k] = 0.5 * (inside + outside)
        again = held(found, numbers, np.arange(len(bound)) != k)
        if fault(again.fit.free, again.fit.numbers) is None:
            inside, best = float(numbers[k]), again
        else:
            outside = float(numbers[k])
    bound[k] = best is not None
    return best or found, bound


def vanished(found: Found, known: Certainty) -> tuple[Found, Mask]:
    """The fit with 0 for what may be 0 and has come near to it; (names,) which parameters are.

    So near that the logarithm tells no more: it would run away for ever.
    """
    free, numbers = found.fit.free, found.fit.numbers.copy()
    near = (free.positive > 0) & (numbers[:-2] < -VAGUE) & ~np.array(known.told)
    may = [name != LOAD and not fault(free, numbers, **{name: 0.0}) for name in free.names]
    if (zero := near & np.array(may)).any():
        numbers[:-2][zero] = GONE
        found = held(found, numbers, ~zero)
    return found, zero


def fault(free: Free, numbers: Floats, **changes: float) -> str | None:
    """Why no machine has these parameters; None: one may."""
    told = dict(zip(free.names, map(float, free.values(numbers)), strict=True))
    whole = {name: float(x) for name, x in free.start._asdict().items()}
    every = whole | told | changes
    return free.drive.fault({name: every[name] for name in whole})


def _blamed(fit: Fit, error: Floats) -> int | None:
    """The least known parameter with which, where it began, the others are a machine."""
    if fault(fit.free, fit.numbers) is None:
        return None
    for k in np.argsort(-digits(error), kind="stable").tolist():
        numbers = fit.numbers.copy()
        numbers[k] = fit.free.begun[k]
        if fault(fit.free, numbers) is None:
            return int(k)
    return None
