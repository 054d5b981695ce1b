"""Points that move by each other's differences: differential evolution with a memory (SHADE).

Tanabe and Fukunaga, CEC 2013: current-to-pbest/1 with an archive (Zhang and Sanderson, IEEE Trans.
Evolutionary Computation 13(5), 2009), whose factors are drawn about those that have succeeded. A
point gives way to its own trial alone, so that a trial which cannot be better than its point may
end early.
"""

from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import Floats

#: Places of the memory, and the width of what is drawn about one of them.
PLACES, WIDTH = 6, 0.1
#: Share of the points of which one is the best that others move to, and points in the archive for
#: each that is alive.
BEST, ARCHIVE = 0.11, 2.6


class Points(NamedTuple):
    """Where everyone is, and what has been learnt."""

    places: Floats  # (n, size)
    score: Floats  # (n,)
    beaten: Floats  # (archive, size) places that were given up
    memory: Floats  # (2, ``PLACES``) factors on differences, and shares that are crossed
    turn: Floats  # (1,) the place of the memory that is written next


class Trials(NamedTuple):
    """One for every point."""

    places: Floats  # (n, size)
    factors: Floats  # (2, n) of the difference, and the share that is crossed


def begun(places: Floats, score: Floats) -> Points:
    """Before anything was learnt."""
    return Points(places, score, places[:0], np.full((2, PLACES), 0.5), np.zeros(1))


def tried(points: Points, room: tuple[Floats, Floats], rng: np.random.Generator) -> Trials:
    """Trials of four points or more within ``room``, from (size,) to (size,)."""
    places, count = points.places, len(points.places)
    place = rng.integers(PLACES, size=count)
    crossed = np.clip(rng.normal(points.memory[1, place], WIDTH), 0.0, 1.0)
    factor = np.zeros(count)
    while (none := factor <= 0.0).any():
        factor[none] = points.memory[0, place[none]] + WIDTH * rng.standard_cauchy(none.sum())
    factor = np.minimum(factor, 1.0)
    order = np.argsort(-points.score, kind="stable")[: max(round(BEST * count), 2)]
    everyone = np.concatenate([places, points.beaten])
    own = np.arange(count)
    one = (own + rng.integers(1, count, count)) % count
    other = rng.integers(len(everyone), size=count)
    while (same := (other == own) | (other == one)).any():
        other[same] = rng.integers(len(everyone), size=same.sum())
    steps = places[rng.choice(order, count)] - places + places[one] - everyone[other]
    moved = places + factor[:, None] * steps
    for end, beyond in zip(room, (np.less, np.greater), strict=True):
        moved = np.where(beyond(moved, end), 0.5 * (end + places), moved)  # half way to the end
    taken = rng.random(places.shape) < crossed[:, None]
    taken[own, rng.integers(places.shape[1], size=count)] = True
    return Trials(np.where(taken, moved, places), np.stack([factor, crossed]))


def learnt(points: Points, trials: Trials, score: Floats, rng: np.random.Generator) -> Points:
    """Whoever is beaten by its trial makes room for it; what has succeeded is remembered."""
    better, kept = score > points.score, score >= points.score
    beaten = np.concatenate([points.beaten, points.places[better]])
    room = int(ARCHIVE * len(kept))
    if len(beaten) > room:
        beaten = beaten[rng.permutation(len(beaten))[:room]]
    memory, turn = points.memory.copy(), points.turn
    gained = _gained(points.score[better], score[better])
    if gained.sum() > 0.0:
        own = trials.factors[:, better]
        mean = own**2 @ gained / np.maximum(own @ gained, np.finfo(float).tiny)  # Lehmer's
        memory[:, int(turn[0])], turn = mean, (turn + 1.0) % PLACES
    places = np.where(kept[:, None], trials.places, points.places)
    return Points(places, np.where(kept, score, points.score), beaten, memory, turn)


def _gained(before: Floats, after: Floats) -> Floats:
    """By how much trials were better; of points that had failed as much as the best of the others.

    Where all had failed they count the same.
    """
    gained = after - before
    finite = np.isfinite(gained)
    return np.where(finite, gained, gained[finite].max() if finite.any() else 1.0)
