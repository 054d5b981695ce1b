"""Certainty of each parameter: intervals, undetermined combinations, values that are kept.

The residual of a fit is coloured: errors of the model last longer than a sample. Therefore the
covariance is the sandwich of White and of Newey and West (Econometrica 55, 1987) with the
residual's own correlation in the middle, not the inverse of the normal matrix alone.

Parameters that a log does not determine are kept at their start, and the others are fitted again.

Of parameters that only matter in combination, such as a gain and everything that it drives, one is
held: the others are determined if that one is right. Poorly known parameters are all kept at their
start.

A parameter that ends at a bound of what a machine can have is kept there: the logarithm of a
friction that does not exist runs away; a break-away torque below the Coulomb torque is impossible.
Intervals from slopes are not valid there.

Intervals from the residual describe the effect of chance on a correct model. An incorrect one has
other parameters in another motion: each half of a log is fitted by itself, and a difference shows a
deficiency of the model, or a change.
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
#: Parameters of a combination that are named: those with at least this share of the largest one.
NAMED = 0.2
#: Number of bisections of the way to a bound, with the other parameters fitted again each time.
HALVED = 8
#: A logarithm that is 0 to all digits.
GONE = -60.0
#: Relative widening of an interval from which it is reported, and least relative width.
WIDER, SEEN = 0.5, 1e-4
#: Of the parameters with errors of at least this share of the largest, the last one is held.
NEARLY = 0.8
#: Attempts until the fit is acceptable: relative change of a combination above which one of its
#: parameters is held; and whether parameters that remain undetermined are put back to their start.
TRIED = ((TOGETHER, True), (KNOWN, True), (TOGETHER, False))
#: Undetermined parameters stay at their start unless the fit gets worse than chance explains with
#: this probability.
CHANCE = 1e-3
#: States of a parameter: determined by the log, or not; or a remark instead of an interval;
#: its interval is valid if the held parameters are right.
TOLD, NOT_TOLD = "yes", "no"
BOUND, HELD, GIVEN = "at its bound", "held", "given"
#: A parameter that is visible only at changes of flank; least share of the log on either flank.
GAP, RARE = "backlash", 0.01
HIDDEN = (
    "the backlash is not visible in this log, as a weight keeps one flank in contact; "
    "set to 0, measure it"
)
#: Largest number of parameters that are named as changing with one.
OTHERS = 3


class Combination(NamedTuple):
    """A direction in which the parameters may change together."""

    change: float  # relative, of the one that changes most, within which the log tells nothing
    shares: dict[str, float]  # of each parameter, the largest is 1 or -1

    def line(self) -> str:
        """Description of a common change of parameters that the log does not reveal."""
        change = percent(self.change) if self.change < 10.0 else f"a factor of {self.change:.2g}"
        (first, _), *others = sorted(self.shares.items(), key=lambda item: -abs(round(item[1], 9)))
        if not others:
            return f"{first} is known only within {change}"
        rest = f" and {len(others) - OTHERS} more" if len(others) > OTHERS else ""
        shown = (f"{name} ({100 * self.change * x:+.3g} %)" for name, x in others[:OTHERS])
        return f"{first} may change by {change} if others do too: {', '.join(shown)}{rest}"


class Certainty(NamedTuple):
    """Certainty of each parameter of a fit, in the order of ``free``."""

    value: Floats
    low: Floats  # ends of the interval; nan: none, the parameter is at its bound
    high: Floats
    error: Floats  # standard error as a share of the value, see ``FreeParameters.shares``
    state: tuple[str, ...]  # ``TOLD``, ``NOT_TOLD``, ``GIVEN``, ``HELD`` or ``BOUND``
    untold: tuple[Combination, ...]  # combinations that the log does not tell, the worst first
    late: tuple[float, float]  # ends of the interval of the delay [samples]
    covariance: Floats  # (names + 2, names + 2) of the numbers
    inflated: Floats  # (names + 2,) variance of each number over that under white noise

    @property
    def identifiable(self) -> Mask:
        """(names,) True for parameters that the log determines."""
        return np.isin(self.state, (TOLD, GIVEN))


def certainty(fit: Fit, free: Mask | None = None) -> Certainty:
    """Intervals of the parameters, and undetermined combinations.

    ``free`` (names,) are those that are not taken as known; None: all of them.
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
    far_off = far * error[-2] if fit.jacobian[..., -2].any() else 0.0  # else not looked for
    late = fit.late - far_off, fit.late + far_off
    untold = _untold(fit, covariance[:-2, :-2])
    return Certainty(fit.values, low, high, relative, state, untold, late, covariance, inflated)


def _yes_or_no(identifiable: Mask) -> tuple[str, ...]:
    return tuple(np.where(identifiable, TOLD, NOT_TOLD).tolist())


def combined(one: Certainty, other: Certainty) -> Certainty:
    """Certainty common to both: where slopes change much, those at one place can be misleading."""
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
    """(names,) parameters that the log does not determine even if all others are known."""
    rows = rows_of(fit.jacobian, fit.problem.scale)[:, :-2]
    alone = fit.free.shares(fit.numbers) / np.hypot(np.linalg.norm(rows, axis=0), 1.0 / VAGUE)
    return np.asarray(alone > TOGETHER)


def root_of(slopes: Floats, scale: Floats) -> Floats:
    """(numbers, numbers) root of the information in slopes (steps, outputs, numbers).

    ``scale`` (outputs,) is the size of their residuals, which are white.
    """
    return np.asarray(np.linalg.qr(rows_of(slopes, scale), mode="r"))


def errors_of(*roots: Floats) -> Floats:
    """(numbers,) standard errors from all of these roots, and from the prior ``VAGUE``."""
    numbers = roots[0].shape[1]
    _, sizes, right = np.linalg.svd(np.vstack([*roots, np.eye(numbers) / VAGUE]))
    return np.asarray(np.linalg.norm(right.T / sizes, axis=1))


def _untold(fit: Fit, covariance: Floats) -> tuple[Combination, ...]:
    """Principal directions of the relative errors that are too long."""
    rising = (fit.free.positive > 0) | (fit.numbers[:-2] >= 0.0)
    shares = fit.free.shares(fit.numbers) * np.where(rising, 1.0, -1.0)
    lengths, directions = np.linalg.eigh(covariance * np.outer(shares, shares))
    combinations = []
    for length, direction in zip(np.sqrt(np.maximum(lengths, 0.0)), directions.T, strict=True):
        most = digits(np.abs(direction)).argmax()  # of two that change alike the first
        change = float(length * abs(direction[most]))
        if change < KNOWN:
            continue
        relative = zip(fit.free.names, (direction / direction[most]).tolist(), strict=True)
        combinations.append(Combination(change, {k: x for k, x in relative if abs(x) > NAMED}))
    return tuple(sorted(combinations, key=lambda one: -one.change))


def hold_untold(fit: Fit, known: Certainty) -> tuple[Fit, Certainty, str]:
    """The fit with undetermined parameters at their start, and others at their bounds.

    Also returns the certainty of each parameter in this fit, and a note for the user: "" if the log
    determines everything.
    """
    fit, edge = at_bound(fit, known)
    fit, zero = at_zero(fit, known)
    if (bound := edge | zero).any():
        known = certainty(fit, ~bound)
    if known.identifiable.all():
        return fit, known, ""
    nowhere = unseen(fit) & ~bound
    fits = dict[bytes, Fit]()  # by what moved: several ways meet
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
    """Fit again with parameters that are not ``free`` at their start or at their bound.

    ``back``: undetermined parameters are put back to their start too, as long as the machine
    remains the same.
    """

    def only(moving: Mask) -> tuple[Fit, Certainty]:
        here = np.append(moving | bound, [True, True])
        numbers = np.where(here, fit.numbers, fit.free.begun)
        again = fits.get(moving.tobytes()) or refitted(fit, numbers, moving)
        fits[moving.tobytes()] = again
        moves = np.append(np.ones(len(moving)), again.problem.moves[-2:])
        return again, certainty(fitted(again.problem._replace(moves=moves), again.numbers), free)

    again, sure = only(free)  # intervals if those that are held are right
    while back and not sure.identifiable[free].all() and _same(fit, again, known, int(free.sum())):
        again, there = only(free & sure.identifiable)
        sure, before = combined(sure, there), sure
        if sure.state == before.state:
            break
    return again, sure


def _same(fit: Fit, again: Fit, known: Certainty, untold: int) -> bool:
    """True if the machine is still possible, and the fit is not worse than by chance.

    ``untold`` parameters are at their start, in addition to the held ones, which cost nothing.
    """
    if fault(again.free, again.numbers):
        return False
    least = np.maximum(fit.rms, fit.problem.scale)  # of a log without noise nothing is left
    worse = np.sum((again.rms**2 - fit.rms**2) / least**2) * len(fit.residual)
    limit = chi2.isf(CHANCE, max(untold, 1)) * max(known.inflated.max(), 1.0)
    return bool(worse <= limit)


def _one_of_each(fit: Fit, free: Mask, limit: float) -> Mask:
    """(names,) True if not held: one is held of each combination that may change by ``limit``."""
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
    """The fit with physically possible values, and (names,) the parameters moved to a bound for it.

    This is the least certain parameter that can be the cause. If no single parameter is the cause,
    the fit is returned as it is, still impossible.
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
    """The fit with 0 for parameters that have come close to a possible 0; (names,) which these are.

    So close that the logarithm has no effect: it would run away for ever.
    """
    free, numbers = fit.free, fit.numbers.copy()
    near = (free.positive > 0) & (numbers[:-2] < -VAGUE) & ~known.identifiable
    may = [name != LOAD and not fault(free, numbers, **{name: 0.0}) for name in free.names]
    if (zero := near & np.array(may)).any():
        numbers[:-2][zero] = GONE
        fit = refitted(fit, numbers, ~zero)
    return fit, zero


def fault(free: FreeParameters, numbers: Floats, **changes: float) -> str | None:
    """Reason why no machine has these parameters; None: they are possible."""
    fitted = dict(zip(free.names, map(float, free.values(numbers)), strict=True))
    values = free.starts | fitted | changes
    return free.drive.fault({name: values[name] for name in free.start._fields})


def widened_by_halves(fit: Fit, known: Certainty) -> tuple[Certainty, str]:
    """Certainty with intervals widened to include the fit of either half of the log; a note.

    A half that does not determine a parameter does not affect its interval.
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
    """Certainty without a backlash that the log never crosses from flank to flank, and a line."""
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
