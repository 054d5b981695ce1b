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


#: Linearises about a single individual; None where the derivative is not finite.
Newton = Callable[[Population], Linear | None]

LENGTHS = (1.0, 0.5, 0.25, 0.1)
#: Errors below this share of the largest one weigh no more [1].
SMALLEST_ERROR = 1e-6


def proposals(
    point: Floats, error: Floats, jacobian: Floats, frozen: Mask, damping: float, count: int
) -> tuple[Floats, Floats]:
    """``count`` points around ``point`` and the damping of each.

    Dampings span three decades to either side of ``damping``; ``frozen`` parameters stay.
    """
    weight = 1.0 / np.maximum(np.abs(error), SMALLEST_ERROR * np.abs(error).max())
    free = jacobian * ~frozen
    normal = free.T @ (free * weight[:, None])
    slope = free.T @ (weight * error)
    diagonal = np.diag(normal)
    size = np.sqrt(diagonal + 1e-12 * diagonal.max() + np.finfo(float).tiny)
    values, basis = np.linalg.eigh(normal / size / size[:, None])
    along = basis.T @ (slope / size)
    dampings = damping * 10.0 ** np.linspace(-3.0, 3.0, -(-count // len(LENGTHS)))
    steps = (basis @ (along[:, None] / (np.maximum(values, 0.0)[:, None] + dampings))).T / size
    steps[:, frozen] = 0.0
    points = np.concatenate([point - length * steps for length in LENGTHS])
    return points[:count], np.tile(dampings, len(LENGTHS))[:count]
