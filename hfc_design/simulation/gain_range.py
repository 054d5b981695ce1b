"""By which factors the whole command may be multiplied until the machine no longer passes."""

from collections.abc import Callable

import numpy as np

from hfc_design.core.numbers import Floats, Mask

#: Factors on the whole command that are tried at once, and the largest of them.
FACTORS, LARGEST_FACTOR = 32, 16.0
#: And the smallest.
SMALLEST_FACTOR = LARGEST_FACTOR ** (1.0 / FACTORS - 1.0)


def gain_range(kept: Callable[[Floats], Mask]) -> tuple[float, float] | None:
    """The factors between which the machine passes; ``kept`` judges 1 and others at once.

    None: not with the factor of 1, the first of what it returns. The scan is geometric, from
    ``SMALLEST_FACTOR`` to ``LARGEST_FACTOR``, and one of its steps is divided once more.
    """
    up = np.geomspace(1.0, LARGEST_FACTOR, FACTORS + 1)[1:]
    good = kept(np.append(up, 1.0 / up[:-1]))
    if not good[0]:
        return None
    ends = []
    for ratios, well in ((up, good[1 : FACTORS + 1]), (1.0 / up[:-1], good[FACTORS + 1 :])):
        lost = int(np.argmin(well)) if not well.all() else len(well)
        ends.append((np.append(1.0, ratios)[lost], ratios[min(lost, len(ratios) - 1)]))
    (high, beyond), (low, below) = ends
    fine = np.append(
        np.geomspace(high, beyond, FACTORS + 2)[1:-1], np.geomspace(low, below, FACTORS + 1)[1:-1]
    )
    good = kept(fine)
    upper, lower = good[1 : FACTORS + 1], good[FACTORS + 1 :]
    most = np.append(high, fine[:FACTORS])[int(np.append(upper, False).argmin())]
    least = np.append(low, fine[FACTORS:])[int(np.append(lower, False).argmin())]
    return float(least), float(most)


def gain_told(gain: tuple[float, float]) -> str:
    """Factors on the command between which a machine passes; beyond the ends none was tried."""
    low, high = (f"{factor:.3g}" for factor in gain)
    low = f"at most {low}" if gain[0] <= SMALLEST_FACTOR * (1.0 + 1e-9) else low
    high = f"at least {high}" if gain[1] >= LARGEST_FACTOR * (1.0 - 1e-9) else high
    return f"with the command multiplied by {low} to {high}"
