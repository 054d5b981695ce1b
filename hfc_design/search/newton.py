"""Gauss-Newton steps on the sum of absolute errors, proposed many at a time.

The score falls with ``sum |e|``. Weighting each squared error with 1/|e| turns it into a least
squares problem with the same gradient (iteratively reweighted least squares). Its damped normal
equations are solved for many dampings and lengths at once, and the fast population evaluator
decides which of the proposals are good.
"""

from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from threadpoolctl import threadpool_limits

from hfc_design.controllers.genome import AnyPopulation, Space
from hfc_design.core.numbers import Floats, Integers, Mask


class Linear(NamedTuple):
    """A closed loop linearised about one individual."""

    error: Floats  # (steps,) tracking error [rad]
    jacobian: Floats  # (steps, chosen) derivative of the error by the parameters
    chosen: Integers | None = None  # (chosen,) indices of these parameters; None: all


TINY = float(np.finfo(np.float64).tiny)

#: Shares of the motion that are linearised. A loop that still oscillates drifts in phase, which
#: makes late errors look more sensitive than they are; the first part alone gives better steps.
HORIZONS = (0.1, 0.3, 1.0)
#: Shares of a whole step that are tried.
LENGTHS = (1.0, 0.3)
#: Errors below this share of the largest one get no larger weight [1].
SMALLEST_ERROR = 1e-6


def individuals(
    genome: Any, best: AnyPopulation, linear: Linear, damping: float, count: int
) -> tuple[AnyPopulation, Floats]:
    """Return ``count`` proposals around the individual ``best``, and the damping of each."""
    space: Space = genome.space()
    points = np.repeat(space.vectors(best), count, axis=0)
    chosen = np.arange(points.shape[1]) if linear.chosen is None else linear.chosen
    free = ~space.frozen[chosen]
    chosen, linear = chosen[free], linear._replace(jacobian=linear.jacobian[:, free])
    points[:, chosen], dampings = proposals(points[0, chosen], linear, damping, count)
    return space.from_vectors(np.clip(points, space.low, space.high), best), dampings


def some_numbers(
    genome: Any, best: AnyPopulation, count: int, rng: np.random.Generator
) -> Integers:
    """Return indices of up to ``count`` random numbers of an individual that may change.

    A step with few numbers costs little, and the next step changes other numbers. Numbers at
    an end of their range are left out: a step that relies on a clipped number is useless.
    """
    space: Space = genome.space()
    point = space.vectors(best)[0]
    free = np.flatnonzero(~space.frozen & (point > space.low) & (point < space.high))
    return np.sort(rng.choice(free, min(count, len(free)), replace=False))


def proposals(point: Floats, linear: Linear, damping: float, count: int) -> tuple[Floats, Floats]:
    """Return points (count, chosen) around ``point`` (chosen,), and the damping of each (count,).

    Dampings span three decades to either side of ``damping``.
    """
    each = -(-count // (len(HORIZONS) * len(LENGTHS)))
    dampings = damping * 10.0 ** np.linspace(-3.0, 3.0, each)
    floor = max(SMALLEST_ERROR * np.abs(linear.error).max(), TINY)
    weight = 1.0 / np.maximum(np.abs(linear.error), floor)
    rows = np.round(np.array((0.0, *HORIZONS)) * len(weight)).astype(int)
    parameters = linear.jacobian.shape[1]
    normal, slope = np.zeros((parameters, parameters)), np.zeros(parameters)
    nothing = np.zeros(parameters, bool)  # is frozen
    points = []
    # For matrices of this size, a second thread gains little; if another program needs the core,
    # it makes the computation up to thirty times slower.
    with threadpool_limits(1, user_api="blas"):
        for start, stop in pairwise(rows):  # each horizon extends the previous sums
            block, weights = linear.jacobian[start:stop], weight[start:stop]
            normal = normal + block.T @ (block * weights[:, None])
            slope = slope + block.T @ (weights * linear.error[start:stop])
            steps = damped(normal, slope, nothing, dampings)
            points += [point + length * steps for length in LENGTHS]
    return np.concatenate(points)[:count], np.tile(dampings, len(points))[:count]


def damped(normal: Floats, slope: Floats, frozen: Mask, dampings: Floats) -> Floats:
    """Return steps (dampings, parameters) with Marquardt's scaling; 0 for frozen parameters."""
    diagonal = np.diag(normal)
    size = np.sqrt(diagonal + 1e-12 * diagonal.max() + TINY)
    free = ~frozen / size
    values, basis = np.linalg.eigh(normal * free * free[:, None])
    along = basis.T @ (slope * free)
    steps = basis @ (along[:, None] / (np.maximum(values, 0.0)[:, None] + dampings))
    return np.asarray(-steps.T * free)
