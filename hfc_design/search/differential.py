"""Differential evolution that adapts its parameters (L-SHADE).

Tanabe and Fukunaga, CEC 2014: current-to-pbest/1 with an archive (Zhang and Sanderson, IEEE Trans.
Evolutionary Computation 13(5), 2009). Its factors are drawn about those that have succeeded, and
the number of points decreases. A point is replaced only by its own trial, so that a trial that
cannot be better than its point may end early.
"""

from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import Floats, Integers

#: Places of the memory, and the width of what is drawn about one of them.
PLACES, WIDTH = 6, 0.1
#: Share of best points, one of which each point moves to; places in the archive for each of the
#: first points.
BEST, ARCHIVE = 0.11, 2.6


class Points(NamedTuple):
    """Points, and the adapted parameters."""

    places: Floats  # (n, size)
    beaten: Floats  # (archive, size) the last places that were given up
    memory: Floats  # (2, ``PLACES``) factors on differences, and shares that are crossed
    turn: Floats  # (1,) the place of the memory that is written next


class Trials(NamedTuple):
    """One trial for every point."""

    places: Floats  # (n, size)
    factors: Floats  # (2, n) on the differences, and the share that is crossed


def begun(places: Floats) -> Points:
    """Points before anything was learned; (n, size) ``places`` are the first ones."""
    count, size = places.shape
    beaten = np.resize(places, (int(ARCHIVE * count), size))  # nobody yet but themselves
    return Points(places, beaten, np.full((2, PLACES), 0.5), np.zeros(1))


def tried(
    points: Points, score: Floats, room: tuple[Floats, Floats], rng: np.random.Generator
) -> Trials:
    """Trials of four points or more with ``score`` (n,), in ``room`` from (size,) to (size,)."""
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
    low, high = room  # who would go beyond an end goes half of the way to it
    moved = np.where(moved < low, 0.5 * (low + places), moved)
    moved = np.where(moved > high, 0.5 * (high + places), moved)
    taken = rng.random(places.shape) < crossed[:, None]
    taken[indices, rng.integers(places.shape[1], size=count)] = True
    return Trials(np.where(taken, moved, places), np.stack([factor, crossed]))


def learnt(points: Points, trials: Trials, gained: Floats) -> Points:
    """Points after their trials: better trials replace them, successful factors are remembered.

    (n,) ``gained`` is the improvement of each trial, infinite if its point had failed.
    """
    better, memory, turn = gained > 0.0, points.memory.copy(), points.turn
    if better.any():
        finite = better & np.isfinite(gained)
        largest = gained[finite].max() if finite.any() else 1.0
        weight, factors = np.minimum(gained[better], largest), trials.factors[:, better]
        # Lehmer's mean; of factors that are all 0 it is 0.
        mean = (factors**2 @ weight) / np.maximum(factors @ weight, np.finfo(float).tiny)
        memory[:, int(turn[0])], turn = mean, (turn + 1.0) % PLACES
    room = len(points.beaten)
    beaten = np.concatenate([points.beaten, points.places[better]])[-room:]
    places = np.where((gained >= 0.0)[:, None], trials.places, points.places)
    return Points(places, beaten, memory, turn)


def fewer(points: Points, survivors: Integers) -> Points:
    """Reduce the points to the survivors."""
    return points._replace(places=points.places[survivors])
