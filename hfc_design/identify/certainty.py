"""How well a log tells each parameter: intervals, and combinations that it does not tell.

The residual of a fit is coloured: what the model lacks lasts longer than a sample. So the
covariance is the sandwich of White and of Newey and West (Econometrica 55, 1987) with the
residual's own correlation in the middle, not the inverse of the normal matrix alone.
"""

from typing import NamedTuple

import numpy as np
from scipy.stats import norm

from hfc_design.core.numbers import Floats, Mask, digits
from hfc_design.identify.fit import VAGUE, Fit, covariance_of, rows_of

#: The share of repeats in which an interval holds the true value.
CONFIDENCE = 0.95
#: A parameter whose standard error is more than this share of it is not told by the log.
TOLD = 0.25
#: What may change by this much, relative, is nothing that a log of this kind tells.
TOGETHER = 1.0
#: A parameter that takes at least this share of what one takes that changes most is named with it.
NAMED = 0.2


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
    sure = zip(one.told, other.told, inside, strict=True)
    told = tuple(bool(all(each)) for each in sure)
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
    told = tuple(
        bool(share < TOLD) and sure for share, sure in zip(relative, free.tolist(), strict=True)
    )
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
