"""Time stamps as they are written, and samples at even times made of them."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import Floats, Indices, Mask
from hfc_design.logs.log import FEWEST

#: A stamp that is off its place by more than this share of a period trembles.
TREMBLE = 0.02
#: So many samples that are missing in a row are filled in; with more the log is cut there.
FILLED = 5
#: A longer gap [samples] is taken for one of so many; so many are missing of each at most.
LONGEST_GAP, SPARSE = 1000, 100
#: What stays as it is until the next sample.
HELD = ("command", "added")
#: By which share of its error the clock behind the stamps is set right at each of them.
FOLLOWS = 0.1


class Even(NamedTuple):
    """Evenly sampled signals."""

    sample_time: float  # [s]
    values: dict[str, Floats]  # (steps,) each
    usable: Mask  # (steps,) what was recorded
    notes: list[str]


def even(
    time: Floats | None, sample_time: float | None, values: dict[str, Floats], breaks: Mask | None
) -> Even:
    """Signals (rows,) at even times.

    Args:
        time: stamps [s], of each row; None: they follow each other ``sample_time`` apart.
        sample_time: [s]; None: the median of the stamps' distances.
        values: the signals by name.
        breaks: (rows,) where an unknown number of samples is missing before a row.

    Raises:
        ValueError: there is no time; stamps fall; too little is left.
    """
    rows = len(next(iter(values.values())))
    if time is None:
        if sample_time is None:
            raise ValueError("which column is the time? say time=COLUMN [UNIT] or a sample time")
        return _longest(sample_time, values, np.ones(rows, bool), _cuts(breaks), [])
    notes: list[str] = []
    time = time - time[0]  # of seconds since 1970 a period would have few digits
    distance = np.diff(time)
    if (falls := np.flatnonzero(distance < 0)).size:
        raise ValueError(f"its time falls after sample {falls[0] + 1}")
    if not (distance > 0).any():
        raise ValueError("its time stands still: which column is it, and in which unit?")
    if (twice := distance == 0).any():
        notes.append(f"{twice.sum()} samples have the time of the one before, and are left out")
        kept = np.r_[True, ~twice]
        distance = distance[~twice]
        time, values = time[kept], {name: value[kept] for name, value in values.items()}
        breaks = None if breaks is None else breaks[kept]
    rough = sample_time or float(np.median(distance))
    # The log is cut there: no more samples are to be filled in than it has.
    time = np.append(0.0, np.cumsum(np.minimum(distance, LONGEST_GAP * rough)))
    place = _places(time, rough)
    if place[-1] > SPARSE * len(place):
        raise ValueError(
            f"its samples are mostly more than {SPARSE} times {rough:.3g} s apart: is that its "
            "sample time?"
        )
    period = sample_time or float(np.polyfit(place, time, 1)[0])
    return _filled(time, float(f"{period:.9g}"), place, values, breaks, notes)


def _places(time: Floats, period: float) -> Floats:
    """Which sample of an even clock each stamp is.

    The clock follows the stamps by a share, so that neither their trembling nor a ``period`` that
    is a little off miscounts them; a gap is a whole number of periods.
    """
    found, now, clock = [0.0], 0.0, float(time[0])
    for stamp in time[1:].tolist():
        steps = max(round((stamp - clock) / period), 1)
        now, clock = now + steps, clock + steps * period
        clock += FOLLOWS * (stamp - clock)
        found.append(now)
    return np.array(found)


def _filled(
    time: Floats,
    period: float,
    place: Floats,
    values: dict[str, Floats],
    breaks: Mask | None,
    notes: list[str],
) -> Even:
    """At every place; what is missing lies on a straight line, a command stays as it was."""
    start = float(np.mean(time - period * place))  # of the clock, by all stamps
    off = (time - start) / period - place
    tremble = float(np.sqrt(np.mean(off**2)))
    if tremble > TREMBLE:
        notes.append(
            f"time stamps tremble by {100 * tremble:.2g} % of the sample time (rms); the signals "
            "are taken at even times between"
        )
    where = (time - start) / period if tremble > TREMBLE else place
    steps = np.arange(int(place[-1]) + 1)
    recorded = np.zeros(len(steps), bool)
    recorded[np.unique(place.astype(int))] = True
    before = np.clip(np.searchsorted(place, steps, side="right") - 1, 0, len(place) - 1)
    found = {
        name: value[before] if name in HELD else np.interp(steps, where, value)
        for name, value in values.items()
    }
    if missing := int((~recorded).sum()):
        notes.append(f"{missing} of {len(steps)} samples are missing")
    cut = np.zeros(len(steps), bool)
    gaps = np.flatnonzero(np.diff(place) > FILLED + 1)
    for edge in (place[gaps] + 1, place[gaps + 1]):  # what is between has nobody recorded
        cut[edge.astype(int)] = True
    if breaks is not None:
        cut[place[breaks].astype(int)] = True
    return _longest(period, found, recorded, np.flatnonzero(cut), notes)


def _cuts(breaks: Mask | None) -> Indices:
    return np.flatnonzero(np.zeros(0, bool) if breaks is None else breaks)


def _longest(
    period: float, values: dict[str, Floats], usable: Mask, cuts: Indices, notes: list[str]
) -> Even:
    """The longest part between cuts: what happened in one of them nobody knows."""
    ends = [0, *cuts.tolist(), len(usable)]
    parts = [slice(a, b) for a, b in pairwise(ends) if usable[a:b].any()]
    part = max(parts, key=lambda one: one.stop - one.start)
    if len(parts) > 1:
        notes.append(
            f"samples are missing in {len(parts) - 1} places; the longest part without a gap is "
            f"used, {period * part.start:.4g} to {period * part.stop:.4g} s"
        )
    if part.stop - part.start < FEWEST:
        raise ValueError(f"no part without a gap has {FEWEST} samples")
    kept = {name: value[part] for name, value in values.items()}
    return Even(period, kept, usable[part], notes)
