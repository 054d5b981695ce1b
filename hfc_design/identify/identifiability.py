"""Certainty of each parameter: intervals, undetermined combinations, values that are kept.

The residual of a fit is not white noise: errors of the model last longer than a sample. Therefore
the covariance is not just the inverse of the normal matrix, but the sandwich of White and of Newey
and West (Econometrica 55, 1987), which contains the correlation of the residual.

A parameter that a log does not determine is kept at its start, and all others are fitted again.

Some parameters matter only in combination, such as a gain and everything that it drives. One of
them is then *held*: fixed at its start. The others are determined if this start is right.

A parameter may end at a bound of what a machine can have. It is kept there: the logarithm of a
friction that does not exist would fall for ever, and a break-away torque below the Coulomb torque
is impossible. Intervals from slopes are not valid at a bound.

Intervals from the residual describe the effect of chance on a correct model. An incorrect model has
other parameters in another motion. Therefore each half of a log is also fitted by itself; if the
halves differ, the model is deficient or the machine has changed.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.stats import chi2, norm

from hfc_design.core.numbers import Floats, Mask, digits
from hfc_design.core.wording import percent
from hfc_design.identify.fit import (
    FEW,
    TIGHT,
    VAGUE,
    Fit,
    covariance_of,
    fitted,
    levenberg_marquardt,
    refitted,
    residuals,
    rows_of,
    side_by_side,
)
from hfc_design.identify.parameters import LOAD, FreeParameters
from hfc_design.identify.recording import Recording
from hfc_design.identify.replay import Replay, replay

#: Share of repetitions in which an interval contains the true value.
CONFIDENCE = 0.95
#: Relative standard error above which the log does not determine a parameter.
KNOWN = 0.25
#: Relative change above which logs of this kind cannot determine a combination.
TOGETHER = 1.0
#: Share of the largest change in a combination above which a parameter is named as a part of it.
NAMED = 0.2
#: Number of bisections in the search for a bound; the other parameters are fitted again in each.
HALVED = 8
#: Logarithm of a value that is so small that it counts as 0.
GONE = -60.0
#: Relative widening of an interval above which it is reported; least width for this, relative to
#: the value.
WIDER, SEEN = 0.5, 1e-4
#: Of all parameters whose error is at least this share of the largest error, the last one is held.
NEARLY = 0.8
#: Attempts until a fit is acceptable: relative change of a combination above which one of its
#: parameters is held; True if parameters that remain undetermined return to their start.
TRIED = ((TOGETHER, True), (KNOWN, True), (TOGETHER, False))
#: Undetermined parameters return to their start, unless the fit then becomes so much worse that
#: chance would cause this with less than this probability.
CHANCE = 1e-3
#: States of a parameter: the log determines it, or not; its value is at a bound, or held at its
#: start; the log determines it if the held parameters are right.
TOLD, NOT_TOLD = "yes", "no"
BOUND, HELD, GIVEN = "at its bound", "held", "given"
#: Parameter that a log shows only if the axis changes flank; least share of the log on each flank.
GAP, RARE = "backlash", 0.01
HIDDEN = (
    "the backlash is not visible in this log, as the axis stays on one flank; set to 0, measure it"
)
#: Largest number of other parameters in the line on a combination.
OTHERS = 3


class Combination(NamedTuple):
    """Parameters that may change together without a visible effect in the log."""

    change: float  # relative standard error of the parameter that changes most
    shares: dict[str, float]  # relative change of each parameter, as a share of that one's

    def line(self) -> str:
        """Return a line that describes the common change of the parameters."""
        change = percent(self.change) if self.change < 10.0 else f"a factor of {self.change:.2g}"
        (first, _), *others = sorted(self.shares.items(), key=lambda item: -abs(round(item[1], 9)))
        if not others:
            return f"{first} is known only within {change}"
        rest = f" and {len(others) - OTHERS} more" if len(others) > OTHERS else ""
        shown = (f"{name} ({100 * self.change * x:+.3g} %)" for name, x in others[:OTHERS])
        return f"{first} may change by {change} if others do too: {', '.join(shown)}{rest}"


class Certainty(NamedTuple):
    """Certainty of each parameter of a fit; arrays (names,) are in the order of ``free.names``."""

    value: Floats
    low: Floats  # lower and upper end of the interval; nan if the parameter is at its bound
    high: Floats
    error: Floats  # standard error as a share of the value, see ``FreeParameters.shares``
    state: tuple[str, ...]  # ``TOLD``, ``NOT_TOLD``, ``GIVEN``, ``HELD`` or ``BOUND``
    untold: tuple[Combination, ...]  # that the log does not determine, the worst first
    late: tuple[float, float]  # ends of the interval of the delay [samples]
    covariance: Floats  # (names + 2, names + 2) of the numbers
    inflated: Floats  # (names + 2,) variance of each number divided by that under white noise

    @property
    def identifiable(self) -> Mask:
        """(names,) True for parameters that the log determines: states ``TOLD`` and ``GIVEN``."""
        return np.isin(self.state, (TOLD, GIVEN))


def certainty(fit: Fit, free: Mask | None = None) -> Certainty:
    """Return intervals of the parameters, and undetermined combinations.

    ``free`` (names,) is False for parameters that count as known; None: no parameter does.
    """
    free = np.ones(len(fit.free.names), bool) if free is None else free
    counts = np.append(free, [True, True])
    fit = fit._replace(jacobian=fit.jacobian * counts)
    covariance, inflated = covariance_of(fit)
    covariance = covariance * np.outer(counts, counts)
    error = np.sqrt(np.diag(covariance))
    far = norm.ppf(0.5 + 0.5 * CONFIDENCE)
    low, high = (fit.free.values(fit.numbers + sign * far * error) for sign in (-1.0, 1.0))
    relative = error[:-2] * fit.free.shares(fit.numbers)
    state = _yes_or_no((relative < KNOWN) & free)
    far_off = far * error[-2] if fit.jacobian[..., -2].any() else 0.0  # 0: it was not fitted
    late = fit.late - far_off, fit.late + far_off
    untold = _untold(fit, covariance[:-2, :-2])
    return Certainty(fit.values, low, high, relative, state, untold, late, covariance, inflated)


def _yes_or_no(identifiable: Mask) -> tuple[str, ...]:
    return tuple(np.where(identifiable, TOLD, NOT_TOLD).tolist())


def combined(one: Certainty, other: Certainty) -> Certainty:
    """Return ``other``'s values, with intervals of both joined: slopes at one point can mislead."""
    low, high = np.minimum(one.low, other.low), np.maximum(one.high, other.high)
    inside = (low <= other.value) & (other.value <= high)
    return one._replace(
        value=other.value,
        low=np.minimum(low, other.value),
        high=np.maximum(high, other.value),
        error=np.maximum(one.error, other.error),
        state=_yes_or_no(one.identifiable & other.identifiable & inside),
    )


def unseen(fit: Fit) -> Mask:
    """Return (names,) True for parameters unknown from the log even if all others are known."""
    rows = rows_of(fit.jacobian, fit.problem.scale)[:, :-2]
    alone = fit.free.shares(fit.numbers) / np.hypot(np.linalg.norm(rows, axis=0), 1.0 / VAGUE)
    return np.asarray(alone > TOGETHER)


def root_of(slopes: Floats, scale: Floats) -> Floats:
    """Return a root (numbers, numbers) of the information in slopes (steps, outputs, numbers).

    ``scale`` (outputs,) is the rms of the residuals, which are taken as white noise.
    """
    return np.asarray(np.linalg.qr(rows_of(slopes, scale), mode="r"))


def _untold(fit: Fit, covariance: Floats) -> tuple[Combination, ...]:
    """Return the principal directions of the relative errors that are longer than ``KNOWN``."""
    rising = (fit.free.positive > 0) | (fit.numbers[:-2] >= 0.0)
    shares = fit.free.shares(fit.numbers) * np.where(rising, 1.0, -1.0)
    lengths, directions = np.linalg.eigh(covariance * np.outer(shares, shares))
    combinations = []
    for length, direction in zip(np.sqrt(np.maximum(lengths, 0.0)), directions.T, strict=True):
        most = digits(np.abs(direction)).argmax()  # the first of two that change alike
        change = float(length * abs(direction[most]))
        if change < KNOWN:
            continue
        relative = zip(fit.free.names, (direction / direction[most]).tolist(), strict=True)
        combinations.append(Combination(change, {k: x for k, x in relative if abs(x) > NAMED}))
    return tuple(sorted(combinations, key=lambda one: -one.change))


def hold_untold(fit: Fit, known: Certainty) -> tuple[Fit, Certainty, str]:
    """Return the fit with undetermined parameters at their start, impossible ones at their bounds.

    Also return the certainty of each parameter in this fit, and a note for the user, which is "" if
    the log determines everything.
    """
    fit, edge = at_bound(fit, known)
    fit, zero = at_zero(fit, known)
    if (bound := edge | zero).any():
        known = certainty(fit, ~bound)
    if known.identifiable.all():
        return fit, known, ""
    nowhere = unseen(fit) & ~bound
    fits = dict[bytes, Fit]()  # by the parameters that moved: attempts may need the same fit
    for limit, back in TRIED:
        free = _one_of_each(fit, ~bound & ~nowhere, limit)
        again, sure = _again(fit, known, free, bound, back, fits)
        untold = int((free & ~sure.identifiable).sum()) if back else 0
        if same := _same(fit, again, known, untold):
            break
    else:
        again, sure, free = fit, known, np.ones(len(bound), bool)
    where = [bound, ~(free | nowhere), ~sure.identifiable, known.identifiable]
    states = tuple(np.select(where, [BOUND, HELD, NOT_TOLD, TOLD], GIVEN).tolist())
    ends = {
        name: np.where(sure.identifiable | free, getattr(sure, name), getattr(known, name))
        for name in ("low", "high", "error")
    }
    for name in ("low", "high"):
        ends[name] = np.where(bound, np.nan, ends[name])
    value = np.where(zero, 0.0, again.values)
    note = _note(fit.free.names, states, same and back)
    return again, known._replace(value=value, state=states, **ends), note


def _again(
    fit: Fit, known: Certainty, free: Mask, bound: Mask, back: bool, fits: dict[bytes, Fit]
) -> tuple[Fit, Certainty]:
    """Return a new fit and its certainty; what is not ``free`` stays at its start or its bound.

    ``back``: undetermined parameters return to their start too, as long as the fit remains about
    as good (``_same``). ``fits`` collects the fits made so far.
    """

    def only(moving: Mask) -> tuple[Fit, Certainty]:
        here = np.append(moving | bound, [True, True])
        numbers = np.where(here, fit.numbers, fit.free.begun)
        again = fits.get(moving.tobytes()) or refitted(fit, numbers, moving)
        fits[moving.tobytes()] = again
        moves = np.append(np.ones(len(moving)), again.problem.moves[-2:])
        return again, certainty(fitted(again.problem._replace(moves=moves), again.numbers), free)

    again, sure = only(free)  # intervals are valid if the held parameters are right
    while back and not sure.identifiable[free].all() and _same(fit, again, known, int(free.sum())):
        again, there = only(free & sure.identifiable)
        sure, before = combined(sure, there), sure
        if sure.state == before.state:
            break
    return again, sure


def _same(fit: Fit, again: Fit, known: Certainty, untold: int) -> bool:
    """Return True if ``again`` is a possible machine, and not worse than ``fit`` but by chance.

    ``untold`` is the number of parameters that returned to their start; held ones do not count.
    """
    if fault(again.free, again.numbers):
        return False
    least = np.maximum(fit.rms, fit.problem.scale)  # without noise the residual may be 0
    worse = np.sum((again.rms**2 - fit.rms**2) / least**2) * len(fit.residual)
    limit = chi2.isf(CHANCE, max(untold, 1)) * max(known.inflated.max(), 1.0)
    return bool(worse <= limit)


def _one_of_each(fit: Fit, free: Mask, limit: float) -> Mask:
    """Return ``free`` (names,) without one of each combination that changes by over ``limit``."""
    free, now = free.copy(), certainty(fit, free)
    while now.untold and now.untold[0].change > limit:
        near = np.flatnonzero(now.error >= NEARLY * now.error.max())
        free[near[-1]] = False
        now = certainty(fit, free)
    return free


def _note(names: Sequence[str], states: tuple[str, ...], back: bool) -> str:
    where = "left at its start value" if back else "as found, since its start value fits worse"
    lines = {
        HELD: "fixed at its start value: {}; the log determines others only relative to it",
        NOT_TOLD: f"the log does not determine {{}}: {where}",
        BOUND: "{}: at its lowest or highest possible value, without an interval",
    }
    names_of = {
        line: ", ".join(name for name, x in zip(names, states, strict=True) if x == state)
        for state, line in lines.items()
    }
    return "; ".join(line.format(some) for line, some in names_of.items() if some)


def at_bound(fit: Fit, known: Certainty) -> tuple[Fit, Mask]:
    """Return the fit with possible values, and (names,) True for a parameter moved to its bound.

    This is the least certain parameter that alone makes the values impossible. If no single one
    does, the fit is returned as it is, still impossible.
    """
    bound = np.zeros(len(known.error), bool)

    def placed(k: int, number: float) -> Floats:
        return np.where(np.arange(len(fit.numbers)) == k, number, fit.numbers)

    if fault(fit.free, fit.numbers) is None:
        return fit, bound
    order = np.argsort(-digits(known.error), kind="stable").tolist()
    blamed = (k for k in order if fault(fit.free, placed(k, fit.free.begun[k])) is None)
    if (k := next(blamed, None)) is None:
        return fit, bound
    inside, outside = float(fit.free.begun[k]), float(fit.numbers[k])
    best: Fit | None = None
    for _ in range(HALVED):
        middle = 0.5 * (inside + outside)
        again = refitted(fit, placed(k, middle), np.arange(len(bound)) != k)
        if fault(again.free, again.numbers) is None:
            inside, best = middle, again
        else:
            outside = middle
    bound[k] = best is not None
    return best or fit, bound


def at_zero(fit: Fit, known: Certainty) -> tuple[Fit, Mask]:
    """Return the fit with parameters near 0 at 0, if 0 is possible; and (names,) True for these.

    They are so small that they have no effect: their logarithms would fall for ever.
    """
    free, numbers = fit.free, fit.numbers.copy()
    near = (free.positive > 0) & (numbers[:-2] < -VAGUE) & ~known.identifiable
    may = [name != LOAD and not fault(free, numbers, **{name: 0.0}) for name in free.names]
    if (zero := near & np.array(may)).any():
        numbers[:-2][zero] = GONE
        fit = refitted(fit, numbers, ~zero)
    return fit, zero


def fault(free: FreeParameters, numbers: Floats, **changes: float) -> str | None:
    """Return why no machine has these parameters, after ``changes``; None: they are possible."""
    fitted = dict(zip(free.names, map(float, free.values(numbers)), strict=True))
    values = free.starts | fitted | changes
    return free.drive.fault({name: values[name] for name in free.start._fields})


def widened_by_halves(fit: Fit, known: Certainty) -> tuple[Certainty, str]:
    """Return the certainty with intervals that include the fits of both halves; and a note or "".

    A half of the log that does not determine a parameter does not affect its interval.
    """
    replay, identifiable = fit.problem.residual, known.identifiable
    if not isinstance(replay, Replay) or not identifiable.any():
        return known, ""
    counted = np.flatnonzero(replay.rows.usable)
    first = np.arange(len(replay.rows.usable)) < counted[len(counted) // 2]
    moves = np.append(identifiable, fit.problem.moves[-2:]).astype(float)

    def half(part: Mask) -> Certainty:
        rows = replay.rows._replace(usable=replay.rows.usable * part)
        problem = fit.problem._replace(residual=replace(replay, rows=rows), moves=moves)
        numbers, _ = levenberg_marquardt(problem, fit.numbers, TIGHT, FEW)
        return certainty(fitted(problem, numbers), identifiable)

    low, high, late = known.low.copy(), known.high.copy(), known.late
    for part in side_by_side(half, (first, ~first)):
        tells = identifiable & (part.error < KNOWN) & np.isfinite(part.value)
        low[tells] = np.minimum(low, part.value)[tells]
        high[tells] = np.maximum(high, part.value)[tells]
        middle = 0.5 * (part.late[0] + part.late[1])
        late = min(late[0], middle), max(late[1], middle)
    least = np.maximum(known.high - known.low, SEEN * np.abs(known.value))
    grown = (high - low) > (1.0 + WIDER) * least
    names = ", ".join(np.array(fit.free.names)[grown & identifiable])
    note = f"the halves of the log differ significantly in {names}: their intervals include both"
    return known._replace(low=low, high=high, late=late), note if names else ""


def unseen_backlash(
    fit: Fit, known: Certainty, log: Recording, substeps: int
) -> tuple[Certainty, str]:
    """Return the certainty, with backlash 0 if the log never changes flank; and a line or ""."""
    position, here = fit.free.drive.seen[0], np.array(fit.free.names) == GAP
    others = [name for name in fit.free.drive.encoders if name != position]
    if not here.any() or fit.problem.bandwidth is None or not others:
        return known, ""
    pair = log._replace(outputs={position: log.place, others[0]: log.place})
    residual = replay(fit.free, pair, fit.problem.bandwidth, substeps)
    off = residuals(fit.problem._replace(residual=residual, scale=np.ones(2)), fit.numbers)
    bent = np.quantile(off[:, 0] - off[:, 1], [RARE, 1.0 - RARE])
    if np.ptp(bent) >= 0.5 * known.value[here]:
        return known, ""
    value, low = (np.where(here, 0.0, x) for x in (known.value, known.low))
    state = tuple(np.where(here, NOT_TOLD, known.state).tolist())
    return known._replace(value=value, low=low, state=state), HIDDEN
