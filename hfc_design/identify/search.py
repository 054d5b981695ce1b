"""The whole search: which observer tells most, and what it finds."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import Floats, Mask, within
from hfc_design.identify.certainty import covariance_of
from hfc_design.identify.fit import (
    NOTHING,
    Fit,
    Problem,
    fitted,
    offs,
    searched,
    settled,
    weighed,
)
from hfc_design.identify.free import Free
from hfc_design.identify.recording import Recording
from hfc_design.identify.replay import Residual, replay

#: Bandwidths of the observer that are tried [Hz], none faster than this share of the samples and
#: none slower than so many periods in the log: the first three do not count.
BANDWIDTHS, SHARE, PERIODS = (50.0, 20.0, 5.0), 0.1, 10.0
#: One that is asked for may be this share of the samples; a faster one does not settle.
LARGEST_SHARE = 0.2
#: A slower observer is tried if under the numbers of the faster one it is off by less than so many
#: times as much; whoever knows the machine needs no fast one.
WORTH = 3.0

#: A lag is looked for from so many samples, and is one if it is so many standard errors long.
LAG, CLEAR = 0.5, 4.0

Tell = Callable[[str], None]


class Found(NamedTuple):
    """A fit and how its residual comes about."""

    fit: Fit
    problem: Problem
    bandwidth: float | None  # of the observer [Hz]; 0: open loop; None: the closed loop


def by_command(
    free: Free,
    told: Recording,
    substeps: int,
    tried: Sequence[float],
    seed: int,
    tell: Tell,
    near: bool = False,
) -> Found:
    """Under the command that was recorded, by the observer of the least residual.

    ``tried`` are their ``bandwidths``. ``near``: the machine is known to be near the first start,
    no others are tried.
    """
    first, *others = tried
    best = _first(free, told, replay(free, told, first, substeps), first, seed, tell, near)
    for hz in others:
        residual = replay(best.fit.free, told, hz, substeps)
        problem = best.problem._replace(residual=residual)
        off = offs(problem, best.fit.numbers)
        if not np.sqrt(np.mean(off[:, 0] ** 2)) < WORTH * best.fit.rms[0]:
            break
        if best.fit.rms[0] <= NOTHING * np.std(told.place):
            break  # of which observer there is less is rounding
        again = _ended(problem, best.fit.numbers, best.fit.agreeing, hz, tell)
        if again.fit.rms[0] < best.fit.rms[0]:  # by the position
            best = again
    return _lagged(best)


def _lagged(found: Found) -> Found:
    """The fit with a part of the lateness as a lag, where the log tells one from the other."""
    moves = found.problem.held.copy()
    if not (found.problem.free.sought[1] and moves[-2]) or found.fit.lag:
        return found
    moves[-1] = 1.0
    begun = np.append(found.fit.numbers[:-1], LAG)
    problem = found.problem._replace(held=moves)
    again = _ended(problem, begun, found.fit.agreeing, found.bandwidth)
    error = np.sqrt(covariance_of(again.fit)[0][-1, -1])
    told = again.fit.lag > CLEAR * error and again.fit.rms[0] < found.fit.rms[0]
    return again if told else found


def bandwidths(told: Recording, wanted: float | None) -> list[float]:
    """Those of the observers to try [Hz], the fastest first; the one that is ``wanted``.

    Raises:
        ValueError: the log is too short for an observer, or for this one, or too slow.
    """
    low = PERIODS / told.duration
    if wanted is not None:
        high = LARGEST_SHARE / told.sample_time
        if wanted and not within(low, wanted, high):
            raise ValueError(
                f"an observer of {wanted:g} Hz does not suit it: {low:.3g} to {high:.3g} Hz, by "
                "how long it lasts and how it is sampled"
            )
        return [wanted]
    high = SHARE / told.sample_time
    if not within(0.0, low, high):
        fewest = int(np.ceil(PERIODS / SHARE))
        raise ValueError(
            f"has {len(told.place)} samples, an observer needs {fewest}: record more, or replay "
            "it with --open-loop"
        )
    return [hz for hz in BANDWIDTHS if within(low, hz, high)] or [
        min(high, max(low, BANDWIDTHS[-1]))
    ]


def by_loop(free: Free, told: Recording, residual: Residual, seed: int, tell: Tell) -> Found:
    """In the closed loop that recorded it."""
    return _first(free, told, residual, None, seed, tell)


def held(found: Found, numbers: Floats, keep: Mask) -> Found:
    """Fitted again from ``numbers`` (names + 2,), of which only those of ``keep`` (names,) move.

    Those of ``LATE`` move if they do in ``found``.
    """
    moves = np.append(keep.astype(float), found.problem.held[-2:])
    problem = found.problem._replace(held=moves)
    return _ended(problem, numbers, found.fit.agreeing, found.bandwidth)


def opened(found: Found) -> Fit:
    """The fit where it is, with the slopes of all numbers."""
    keep = np.append(np.ones(len(found.fit.free.names)), found.problem.held[-2:])
    return fitted(found.problem._replace(held=keep), found.fit.numbers, found.fit.agreeing)


def observer(bandwidth: float | None) -> str:
    """What a recording is replayed with, in words."""
    if bandwidth is None:
        return "closed loop"
    return f"observer of {bandwidth:g} Hz" if bandwidth else "open loop"


def _first(
    free: Free,
    told: Recording,
    residual: Residual,
    bandwidth: float | None,
    seed: int,
    tell: Tell,
    near: bool = False,
) -> Found:
    """By many starts, or from one that is ``near``; a delay is looked for but in a closed loop."""
    size = np.array([max(np.std(values), 1e-300) for values in told.outputs.values()])
    late = free.sought[0] if bandwidth is not None else 0.0
    held = np.append(np.ones(len(free.names)), [late, 0.0])
    problem = weighed(Problem(free, residual, size, held), told.command)
    numbers, agreeing = problem.free.near, 0
    if not near:
        tell(f"{observer(bandwidth)}: a hundred starts side by side, the best ten refined")
        numbers, agreeing = searched(problem, seed)
    return _ended(problem, numbers, agreeing, bandwidth, tell)


def _ended(
    problem: Problem,
    numbers: Floats,
    agreeing: int,
    bandwidth: float | None,
    tell: Tell = lambda line: None,
) -> Found:
    tell(f"{observer(bandwidth)}: the best one refined")
    problem, numbers = settled(problem, numbers)
    return Found(fitted(problem, numbers, agreeing), problem, bandwidth)
