"""A normal distribution that moves towards good samples: CMA-ES.

Hansen and Ostermeier, Evolutionary Computation 9(2), 2001, with the constants of Hansen, The CMA
Evolution Strategy: A Tutorial, arXiv:1604.00772, 2016; with many numbers only the variances are
adapted (Ros and Hansen, PPSN X, 2008). As scores may be noisy, the result is the mean.
"""

from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import Floats

#: Largest number of coordinates for which the whole covariance matrix is adapted.
WHOLE = 40
#: How strongly the average of the means, which reduces noise, prefers later ones: with this value
#: it is about the average of the last third (Shamir and Zhang, ICML 2013).
LATER = 2.0
#: Smallest variance of a direction, in shares of the largest, and the largest step.
SMALLEST, LARGEST_STEP = 1e-16, 1e6


class Distribution(NamedTuple):
    """Normal distribution from which points are drawn, and the data by which it adapts."""

    mean: Floats  # (size,)
    step: Floats  # (1,) factor on all standard deviations
    covariance: Floats  # (size, size); or (size, 1), then only variances
    path: Floats  # (size,) decaying sum of the moves of the mean
    steady_path: Floats  # (size,) the same of moves scaled to a covariance of one
    age: Floats  # (1,) number of generations that have been learned
    average: Floats  # (size,) average of the means, in which later ones count more


class Constants(NamedTuple):
    """Constants of the method for a number of samples and a number of coordinates."""

    weights: Floats  # (kept,) of the best samples
    mass: float  # effective number of samples
    step_rate: float
    damping: float
    path_rate: float
    rank_one: float
    rank_mu: float
    length: float  # expected length of a normal vector


def begun(mean: Floats, step: float) -> Distribution:
    """Return a distribution around ``mean`` (size,) before anything was learned."""
    size = len(mean)
    covariance = np.eye(size) if size <= WHOLE else np.ones((size, 1))
    one = np.ones(1)
    still = np.zeros(size)
    return Distribution(mean, step * one, covariance, still, still, 0.0 * one, mean)


def constants(samples: int, size: int) -> Constants:
    """Return the defaults of the tutorial's table 1, with only the positive weights."""
    parents = samples // 2
    weights = np.log(parents + 0.5) - np.log(np.arange(1, parents + 1))
    weights = weights / weights.sum()
    mass = 1.0 / float((weights**2).sum())
    step_rate = (mass + 2.0) / (size + mass + 5.0)
    damping = 1.0 + 2.0 * max(0.0, np.sqrt((mass - 1.0) / (size + 1.0)) - 1.0) + step_rate
    path_rate = (4.0 + mass / size) / (size + 4.0 + 2.0 * mass / size)
    rank_one = 2.0 / ((size + 1.3) ** 2 + mass)
    rank_mu = min(1.0 - rank_one, 2.0 * (mass - 2.0 + 1.0 / mass) / ((size + 2.0) ** 2 + mass))
    if size > WHOLE:  # there is less to learn, so it is learned faster (Ros and Hansen, eq. 6)
        faster = (size + 2.0) / 3.0
        rank_one = min(1.0, faster * rank_one)
        rank_mu = min(1.0 - rank_one, faster * rank_mu)
    length = np.sqrt(size) * (1.0 - 1.0 / (4.0 * size) + 1.0 / (21.0 * size**2))
    rates = (step_rate, damping, path_rate, rank_one, rank_mu, length)
    return Constants(weights, mass, *map(float, rates))


def drawn(distribution: Distribution, samples: int, rng: np.random.Generator) -> Floats:
    """Return points drawn from the distribution, (samples, size)."""
    normal = rng.standard_normal((samples, len(distribution.mean)))
    turn, root = _axes(distribution.covariance)
    return distribution.mean + distribution.step * ((normal * root) @ turn.T)


def learnt(distribution: Distribution, points: Floats, score: Floats) -> Distribution:
    """Return the distribution adapted to ``points`` (samples, size); a larger score is better."""
    mean, step, covariance, path, steady, age, average = distribution
    size = len(mean)
    c = constants(len(points), size)
    best = points[np.argsort(-score, kind="stable")[: len(c.weights)]]
    moves = (best - mean) / step
    move = c.weights @ moves
    turn, root = _axes(covariance)
    whitened = turn @ ((turn.T @ move) / root)
    steady = (1.0 - c.step_rate) * steady
    steady = steady + np.sqrt(c.step_rate * (2.0 - c.step_rate) * c.mass) * whitened
    length = np.linalg.norm(steady)
    settled = np.sqrt(1.0 - (1.0 - c.step_rate) ** (2.0 * (age + 1.0)))
    moving = length / settled < (1.4 + 2.0 / (size + 1.0)) * c.length  # else the step was too small
    path = (1.0 - c.path_rate) * path
    path = path + moving * np.sqrt(c.path_rate * (2.0 - c.path_rate) * c.mass) * move
    stalled = (1.0 - moving) * c.path_rate * (2.0 - c.path_rate)
    old = 1.0 - c.rank_one - c.rank_mu + c.rank_one * stalled
    if covariance.shape[1] == 1:
        more = (c.rank_one * path**2 + c.rank_mu * (c.weights @ moves**2))[:, None]
    else:
        more = c.rank_one * np.outer(path, path) + c.rank_mu * (moves.T * c.weights) @ moves
    grown = step * np.exp(c.step_rate / c.damping * (length / c.length - 1.0))
    mean = mean + step * move
    average = average + (mean - average) * (LATER + 1.0) / (LATER + 1.0 + age)
    others = (np.minimum(grown, LARGEST_STEP), old * covariance + more, path, steady)
    return Distribution(mean, *others, age + 1.0, average)


def _axes(covariance: Floats) -> tuple[Floats, Floats]:
    """Return directions (size, size) and standard deviations along these directions (size,)."""
    if covariance.shape[1] == 1:
        variances, turn = covariance[:, 0], np.eye(len(covariance))
    else:
        variances, turn = np.linalg.eigh(covariance)
    return turn, np.sqrt(np.maximum(variances, SMALLEST * variances.max()))
