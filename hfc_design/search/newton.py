"""Gauss-Newton steps on the sum of absolute errors, proposed many at a time.

The score falls with ``sum |e|``. Weighting each squared error with 1/|e| turns it into a least
squares problem with the same gradient (iteratively reweighted least squares); its damped normal
equations are solved for many dampings and lengths at once, and the population evaluator, which
is fast, decides which of them is any good.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from hfc_design.search.genome import Floats, Mask, Population


class Linear(NamedTuple):
    """A closed loop linearised about one individual."""

    error: Floats  # (steps,) tracking error [rad]
    jacobian: Floats  # (steps, parameters) its derivative


TINY = float(np.finfo(np.float64).tiny)

#: Linearises about a single individual; None where the derivative is not finite.
Newton = Callable[[Population], Linear | None]

#: Shares of the motion that are linearised. A loop that still oscillates drifts in phase, which
#: makes late errors look more sensitive than they are; its beginning alone gives better steps.
HORIZONS = (1.0, 0.3, 0.1)
#: Shares of a whole step that are tried.
LENGTHS = (1.0, 0.3)
#: Errors below this share of the largest one weigh no more [1].
SMALLEST_ERROR = 1e-6


def proposals(
    point: Floats, linear: Linear, frozen: Mask, damping: float, count: int
) -> tuple[Floats, Floats]:
    """``count`` points (count, parameters) around ``point`` and the damping of each.

    Dampings span three decades to either side of ``damping``; ``frozen`` parameters stay.
    """
    each = -(-count // (len(HORIZONS) * len(LENGTHS)))
    dampings = damping * 10.0 ** np.linspace(-3.0, 3.0, each)
    points = []
    for horizon in HORIZONS:
        rows = max(round(horizon * len(linear.error)), 1)
        steps = _steps(linear.error[:rows], linear.jacobian[:rows] * ~frozen, dampings)
        steps[:, frozen] = 0.0
        points += [point + length * steps for length in LENGTHS]
    return np.concatenate(points)[:count], np.tile(dampings, len(points))[:count]


def _steps(error: Floats, jacobian: Floats, dampings: Floats) -> Floats:
    """The reweighted Gauss-Newton step for each damping, (dampings, parameters)."""
    weight = 1.0 / np.maximum(np.abs(error), max(SMALLEST_ERROR * np.abs(error).max(), TINY))
    normal = jacobian.T @ (jacobian * weight[:, None])
    diagonal = np.diag(normal)
    size = np.sqrt(diagonal + 1e-12 * diagonal.max() + TINY)  # Marquardt's scaling
    values, basis = np.linalg.eigh(normal / size / size[:, None])
    along = basis.T @ (jacobian.T @ (weight * error) / size)
    steps = basis @ (along[:, None] / (np.maximum(values, 0.0)[:, None] + dampings))
    return np.asarray(-steps.T / size)
