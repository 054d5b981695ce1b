"""Differential evolution that adapts its parameters (L-SHADE).

Tanabe and Fukunaga, CEC 2014: current-to-pbest/1 with an archive (Zhang and Sanderson, IEEE Trans.
Evolutionary Computation 13(5), 2009). Factors are drawn around values that were successful before,
and the number of points decreases. Only its own trial can replace a point, so the simulation of a
trial that cannot be better than its point may end early.
"""

from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import Floats

#: Number of entries of the memory, and spread of the values that are drawn around an entry.
PLACES, WIDTH = 6, 0.1
#: Share of the best points, towards one of which each point moves; size of the archive, as a
#: multiple of the number of first points.
BEST, ARCHIVE = 0.11, 2.6


class Points(NamedTuple):
    """Points, and the adapted parameters."""

    places: Floats  # (n, size) coordinates of the points
    beaten: Floats  # (archive, size) the archive: coordinates of points that were replaced last
    memory: Floats  # (2, ``PLACES``) factors on differences, and shares of changed coordinates
    turn: Floats  # (1,) index of the entry of the memory that is written next


class Trials(NamedTuple):
    """One trial for every point."""

    places: Floats  # (n, size) coordinates of the trials
    factors: Floats  # (2, n) factor on differences, and share of changed coordinates


def begun(places: Floats) -> Points:
    """Return the first points, at ``places`` (n, size), before anything was learned."""
    count, size = places.shape
    beaten = np.resize(places, (int(ARCHIVE * count), size))  # at first only the points themselves
    return Points(places, beaten, np.full((2, PLACES), 0.5), np.zeros(1))


def tried(
    points: Points, score: Floats, room: tuple[Floats, Floats], rng: np.random.Generator
) -> Trials:
    """Return a trial for each of n >= 4 points with ``score`` (n,), within the bounds ``room``."""
    places, count = points.places, len(score)
    place = rng.integers(PLACES, size=count)
    crossed = np.clip(rng.normal(points.memory[1, place], WIDTH), 0.0, 1.0)
    factor = np.zeros(count)
    while (none := factor <= 0.0).any():
        factor[none] = points.memory[0, place[none]] + WIDTH * rng.standard_cauchy(none.sum())
    factor = np.minimum(factor, 1.0)
    best = np.argsort(-score, kind="stable")[: max(round(BEST * count), 2)]
    everyone, indices = np.concatenate([places, points.beaten]), np.arange(count)
    one = (indices + rng.integers(1, count, count)) % count
    other = rng.integers(len(everyone), size=count)
    while (same := (other == indices) | (other == one)).any():
        other[same] = rng.integers(len(everyone), size=same.sum())
    steps = places[rng.choice(best, count)] - places + places[one] - everyone[other]
    moved = places + factor[:, None] * steps
    low, high = room  # a coordinate beyond a bound goes half of the way to it instead
    moved = np.where(moved < low, 0.5 * (low + places), moved)
    moved = np.where(moved > high, 0.5 * (high + places), moved)
    taken = rng.random(places.shape) < crossed[:, None]
    taken[indices, rng.integers(places.shape[1], size=count)] = True
    return Trials(np.where(taken, moved, places), np.stack([factor, crossed]))


def learnt(points: Points, trials: Trials, gained: Floats) -> Points:
    """Replace points by trials that are no worse, and remember the factors of better trials.

    ``gained`` (n,) is the improvement of the score by each trial, infinite if the point failed.
    """
    better, memory, turn = gained > 0.0, points.memory.copy(), points.turn
    if better.any():
        finite = better & np.isfinite(gained)
        largest = gained[finite].max() if finite.any() else 1.0
        weight, factors = np.minimum(gained[better], largest), trials.factors[:, better]
        # Lehmer's mean; it is 0 if all factors are 0.
        mean = (factors**2 @ weight) / np.maximum(factors @ weight, np.finfo(float).tiny)
        memory[:, int(turn[0])], turn = mean, (turn + 1.0) % PLACES
    room = len(points.beaten)
    beaten = np.concatenate([points.beaten, points.places[better]])[-room:]
    places = np.where((gained >= 0.0)[:, None], trials.places, points.places)
    return Points(places, beaten, memory, turn)
