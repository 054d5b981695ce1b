"""How well a log tells each parameter: intervals, combinations that it does not tell, what stays.

The residual of a fit is coloured: what the model lacks lasts longer than a sample. So the
covariance is the sandwich of White and of Newey and West (Econometrica 55, 1987) with the
residual's own correlation in the middle, not the inverse of the normal matrix alone.

What a log does not tell stays where it began, and what it tells then.

Of parameters that only matter together, as a gain and everything that it drives, one is held: the
others are told if that one is right. What is known badly stays where it began, all of it.

What ended at a bound of what a machine can have stays there: a friction that is not there has a
logarithm that runs away; a break-away torque below the Coulomb torque is no machine's. No interval
that slopes tell is true there.

Intervals by the residual say what chance does to a model that is right. One that is not finds other
parameters in another motion: each half of a log is fitted for itself, and what differs is what the
model lacks, or what changed.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.stats import chi2, norm

from hfc_design.core.numbers import Floats, Mask, digits
from hfc_design.identify.fit import (
    FEW,
    TIGHT,
    VAGUE,
    Fit,
    Found,
    covariance_of,
    fitted,
    held,
    refined,
    rows_of,
    side_by_side,
)
from hfc_design.identify.parameters import LOAD, Free
from hfc_design.identify.replay import Replay

#: The share of repeats in which an interval holds the true value.
CONFIDENCE = 0.95
#: A parameter whose standard error is more than this share of it is not told by the log.
TOLD = 0.25
#: What may change by this much, relative, is nothing that a log of this kind tells.
TOGETHER = 1.0
#: A parameter that takes at least this share of what one takes that changes most is named with it.
NAMED = 0.2
#: The way to a bound is halved so often, and the others fitted again each time.
HALVED = 8
#: A logarithm that is 0 to all digits.
GONE = -60.0
#: What is told of an interval that became wider by this share, and is this wide a share.
WIDER, SEEN = 0.5, 1e-4
#: Of parameters that are known nearly as badly as the worst one, the last is held.
NEARLY = 0.8
#: What is tried until it fits: of each combination that may change by so much, relative, one
#: parameter is held; and whether what is left untold then is put where it began.
TRIED = ((TOGETHER, True), (TOLD, True), (TOGETHER, False))
#: What is not told stays where it began, unless the fit grows worse than chance makes it but once
#: in so many times.
CHANCE = 1e-3
#: What is said of a parameter instead of an interval.
BOUND, HELD, GIVEN = "at its bound", "held", "given"


class Combination(NamedTuple):
    """A direction in which the parameters may change together."""

    change: float  # relative, of the one that changes most, within which the log tells nothing
    shares: dict[str, float]  # of each parameter, the largest is 1 or -1


class Certainty(NamedTuple):
    """Of each parameter of a fit, in the order of ``free``."""

    value: Floats
    low: Floats  # ends of the interval
    high: Floats
    error: Floats  # standard error as a share of the value, see ``Free.shares``
    told: tuple[bool, ...]  # whether the log tells it
    untold: tuple[Combination, ...]  # combinations that it does not tell, the worst first
    late: tuple[float, float]  # ends of the interval of the delay [samples]
    covariance: Floats  # (names + 2, names + 2) of the numbers
    inflated: Floats  # (names + 2,) variance of each number over that under white noise


def both(one: Certainty, other: Certainty) -> Certainty:
    """What is sure by both: where slopes change much, those of one place tell half the truth."""
    low, high = np.minimum(one.low, other.low), np.maximum(one.high, other.high)
    inside = (low <= other.value) & (other.value <= high)
    told = tuple((np.array(one.told) & other.told & inside).tolist())
    low, high = np.minimum(low, other.value), np.maximum(high, other.value)
    error = np.maximum(one.error, other.error)
    return one._replace(value=other.value, low=low, high=high, error=error, told=told)


def certainty(fit: Fit, free: Mask | None = None) -> Certainty:
    """Intervals of the parameters, and what cannot be told.

    ``free`` (names,) are those that are not taken for known; None: all of them.
    """
    free = np.ones(len(fit.free.names), bool) if free is None else free
    fit = fit._replace(jacobian=fit.jacobian * np.append(free, [True, True]))
    covariance, inflated = covariance_of(fit)
    covariance = covariance * np.outer(*2 * [np.append(free, [True, True])])
    error = np.sqrt(np.diag(covariance))
    far = norm.ppf(0.5 + 0.5 * CONFIDENCE)
    low, high = (fit.free.values(fit.numbers + sign * far * error) for sign in (-1.0, 1.0))
    value = fit.free.values(fit.numbers)
    relative = error[:-2] * fit.free.shares(fit.numbers)
    told = tuple(((relative < TOLD) & free).tolist())
    far_off = far * error[-2] if fit.jacobian[..., -2].any() else 0.0  # else not looked for
    late = fit.late - far_off, fit.late + far_off
    untold = _untold(fit, covariance[:-2, :-2])
    return Certainty(value, low, high, relative, told, untold, late, covariance, inflated)


def unseen(fit: Fit) -> Mask:
    """(names,) what the log does not tell even if all others are known."""
    rows = rows_of(fit.jacobian, fit.scale)[:, :-2]
    alone = fit.free.shares(fit.numbers) / np.hypot(np.linalg.norm(rows, axis=0), 1.0 / VAGUE)
    return np.asarray(alone > TOGETHER)


def root_of(slopes: Floats, scale: Floats) -> Floats:
    """(numbers, numbers) root of the information in slopes (steps, outputs, numbers).

    ``scale`` (outputs,) is the size of their residuals, which are white.
    """
    return np.asarray(np.linalg.qr(rows_of(slopes, scale), mode="r"))


def errors_of(*roots: Floats) -> Floats:
    """(numbers,) standard errors by all of these, and by ``VAGUE``, which is known beforehand."""
    numbers = roots[0].shape[1]
    _, sizes, right = np.linalg.svd(np.vstack([*roots, np.eye(numbers) / VAGUE]))
    return np.asarray(np.linalg.norm(right.T / sizes, axis=1))


def _untold(fit: Fit, covariance: Floats) -> tuple[Combination, ...]:
    """Principal directions of the relative errors that are too long."""
    positive, own = fit.free.positive > 0, fit.numbers[:-2]
    shares = fit.free.shares(fit.numbers) * np.where(positive | (own >= 0.0), 1.0, -1.0)
    lengths, directions = np.linalg.eigh(covariance * np.outer(shares, shares))
    found = []
    for length, direction in zip(np.sqrt(np.maximum(lengths, 0.0)), directions.T, strict=True):
        most = digits(np.abs(direction)).argmax()  # of two that change alike the first
        if length * abs(direction[most]) < TOLD:
            continue
        own = direction / direction[most]
        named = {n: float(x) for n, x in zip(fit.free.names, own, strict=True) if abs(x) > NAMED}
        found.append(Combination(float(length * abs(direction[most])), named))
    return tuple(sorted(found, key=lambda one: -one.change))


class Kept(NamedTuple):
    """The fit, and of each parameter how far it is told."""

    found: Found
    known: Certainty  # ends that are nan: none, the parameter is at its bound
    state: tuple[str, ...]  # "yes"; ``GIVEN``, if those held are right; "no"; ``HELD``, ``BOUND``
    note: str  # for the user; "" where the log tells everything


def kept(found: Found, known: Certainty) -> Kept:
    """The fit with what the log does not tell where it began, and what has a bound there."""
    found, edge = bounded(found, known)
    found, zero = vanished(found, known)
    if (bound := edge | zero).any():
        known = certainty(found.fit, ~bound)
    if all(known.told):
        return Kept(found, known, ("yes",) * len(known.told), "")
    nowhere = unseen(found.fit) & ~bound
    fits = dict[bytes, Found]()  # by what moved: several ways meet
    for limit, back in TRIED:
        free = _one_of_each(found, ~bound & ~nowhere, limit)
        again, sure = _again(found, known, free, bound, back, fits)
        untold = int((free & ~np.array(sure.told)).sum()) if back else 0
        if same := _same(found, again, known, untold):
            break
    else:
        again, sure, free = found, known, np.ones(len(bound), bool)
    then = np.array(sure.told)
    where = [bound, ~(free | nowhere), ~then, np.array(known.told)]
    states = tuple(np.select(where, [BOUND, HELD, "no", "yes"], GIVEN).tolist())
    one = then | free
    ends = {
        name: np.where(one, getattr(sure, name), getattr(known, name))
        for name in ("low", "high", "error")
    }
    for name in ("low", "high"):
        ends[name] = np.where(bound, np.nan, ends[name])
    told = tuple(state in ("yes", GIVEN) for state in states)
    value = np.where(zero, 0.0, again.fit.free.values(again.fit.numbers))
    whole = known._replace(value=value, told=told, **ends)
    return Kept(again, whole, states, _note(found, states, same and back))


def _again(
    found: Found, known: Certainty, free: Mask, bound: Mask, back: bool, fits: dict[bytes, Found]
) -> tuple[Found, Certainty]:
    """Fitted with what is not ``free`` where it began or at its bound.

    ``back``: with what is not told where it began too, until that is no longer the same machine.
    """

    def only(keep: Mask) -> tuple[Found, Certainty]:
        here = np.append(keep | bound, [True, True])
        numbers = np.where(here, found.fit.numbers, found.fit.free.begun)
        again = fits.get(keep.tobytes()) or held(found, numbers, keep)
        fits[keep.tobytes()] = again
        every = again.problem._replace(held=np.append(np.ones(len(keep)), again.problem.held[-2:]))
        return again, certainty(fitted(every, again.fit.numbers, 0), free)

    again, sure = only(free)  # intervals if those that are held are right
    while back and not np.array(sure.told)[free].all() and _same(found, again, known, free.sum()):
        again, there = only(free & np.array(sure.told))
        sure, before = both(sure, there), sure
        if sure.told == before.told:
            break
    return again, sure


def _same(found: Found, again: Found, known: Certainty, untold: int) -> bool:
    """Whether it still is a machine, and the fit is not worse than by chance.

    ``untold`` parameters are where they began, beside those that are held, which cost nothing.
    """
    if fault(again.fit.free, again.fit.numbers):
        return False
    least = np.maximum(found.fit.rms, found.fit.scale)  # of a log without noise nothing is left
    worse = np.sum((again.fit.rms**2 - found.fit.rms**2) / least**2) * len(found.fit.residual)
    limit = chi2.isf(CHANCE, max(untold, 1)) * max(known.inflated.max(), 1.0)
    return bool(worse <= limit)


def _one_of_each(found: Found, free: Mask, limit: float) -> Mask:
    """(names,) what is not held: one is of each combination that may change by the ``limit``."""
    free, now = free.copy(), certainty(found.fit, free)
    while now.untold and now.untold[0].change > limit:
        near = np.flatnonzero(now.error >= NEARLY * now.error.max())
        free[near[-1]] = False
        now = certainty(found.fit, free)
    return free


def _note(found: Found, states: tuple[str, ...], back: bool) -> str:
    names = found.fit.free.names
    one, other, last = (
        ", ".join(name for name, x in zip(names, states, strict=True) if x == state)
        for state in (HELD, "no", BOUND)
    )
    parts = []
    if one:
        parts.append(f"held where it began: {one}; the log tells others only beside it")
    if other:
        where = "left where it began" if back else "as it was found, for where it began fits worse"
        parts.append(f"the log does not tell {other}: {where}")
    if last:
        parts.append(f"{last}: at the least or most that a machine can have, no interval is told")
    return "; ".join(parts)


def bounded(found: Found, known: Certainty) -> tuple[Found, Mask]:
    """A fit that is a machine, and (names,) which parameter is at a bound for that.

    That is the one that is known least of those that can be blamed. A fit stays impossible if no
    single parameter can.
    """
    fit, bound = found.fit, np.zeros(len(known.error), bool)

    def placed(k: int, number: float) -> Floats:
        numbers = fit.numbers.copy()
        numbers[k] = number
        return numbers

    if fault(fit.free, fit.numbers) is None:
        return found, bound
    order = np.argsort(-digits(known.error), kind="stable").tolist()
    blamed = (k for k in order if fault(fit.free, placed(k, fit.free.begun[k])) is None)
    if (k := next(blamed, None)) is None:
        return found, bound
    inside, outside = float(fit.free.begun[k]), float(fit.numbers[k])
    best: Found | None = None
    for _ in range(HALVED):
        middle = 0.5 * (inside + outside)
        again = held(found, placed(k, middle), np.arange(len(bound)) != k)
        if fault(again.fit.free, again.fit.numbers) is None:
            inside, best = middle, again
        else:
            outside = middle
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


def halved(found: Found, known: Certainty, states: tuple[str, ...]) -> tuple[Certainty, str]:
    """What is known, its intervals wide enough for what either half of the log tells; a note.

    A half that does not tell a parameter says nothing of it.
    """
    replay = found.problem.residual
    moves = np.array([state in ("yes", GIVEN) for state in states])
    if not isinstance(replay, Replay) or not moves.any():
        return known, ""
    counted = np.flatnonzero(replay.rows.usable)
    middle = np.arange(len(replay.rows.usable)) < counted[len(counted) // 2]
    held = np.append(moves, found.problem.held[-2:]).astype(float)

    def half(part: Mask) -> Certainty:
        rows = replay.rows._replace(usable=replay.rows.usable * part)
        own = found.problem._replace(residual=replace(replay, rows=rows), held=held)
        numbers, _ = refined(own, found.fit.numbers, TIGHT, FEW)
        return certainty(fitted(own, numbers, 0), moves)

    low, high, late = known.low.copy(), known.high.copy(), known.late
    for own in side_by_side(half, (middle, ~middle)):
        tells = moves & (own.error < TOLD) & np.isfinite(own.value)
        low[tells] = np.minimum(low, own.value)[tells]
        high[tells] = np.maximum(high, own.value)[tells]
        mid = 0.5 * (own.late[0] + own.late[1])
        late = min(late[0], mid), max(late[1], mid)
    least = np.maximum(known.high - known.low, SEEN * np.abs(known.value))
    grown = (high - low) > (1.0 + WIDER) * least
    names = ", ".join(np.array(found.fit.free.names)[grown & moves])
    told = f"the halves of the log differ in {names} by more than chance: their intervals hold both"
    return known._replace(low=low, high=high, late=late), told if names else ""
