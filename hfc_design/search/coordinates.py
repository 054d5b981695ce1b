"""Coordinates: the numbers of one individual, whose structure stays, as a point to be moved.

Steps of a distribution of points (CMA-ES, ``distribution``) need no derivative. A derivative says
nothing about controllers that switch, and does not exist for machines of several axes.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import numpy as np

from hfc_design.controllers.genome import Genome, Members, Population
from hfc_design.core.numbers import Floats

#: First standard deviation of a coordinate; see ``_of_space`` for its unit.
STEP = 0.02
#: Largest change of the logarithm of a number without bounds, upwards and downwards.
FAR = 4.0
#: Step, to both sides, of the central difference that gives derivatives by the coordinates.
WIDTH = 1e-5


class Coordinates(NamedTuple):
    """Numbers of an individual as coordinates; each is 0 for the initial individual."""

    size: int
    step: float  # first standard deviation of a distribution
    members: Callable[[Floats], Members]  # points (n, size) -> individuals of the same structure
    room: tuple[Floats, Floats]  # lower and upper bounds of a point, (size,) each


def coordinates(genome: Genome, about: Population) -> Coordinates | None:
    """Return coordinates around a population of one; None if its kind of controller has none."""
    if hasattr(genome, "parts"):
        return _side_by_side(genome, about)
    if hasattr(genome, "space"):
        return _of_space(genome, about)
    stage = genome.around(about)
    if stage is None:
        return None
    start = stage.start

    def members(points: Floats) -> Members:
        return stage.members(start + points, np.repeat(about.tree, len(points)))

    far = np.full(len(start), np.inf)
    return Coordinates(len(start), stage.step, members, (-far, far))


def _side_by_side(genome: Any, about: Any) -> Coordinates | None:
    """Return the coordinates of all parts in a row, scaled to the smallest step of the parts."""
    each = [coordinates(*pair) for pair in zip(genome.parts, about.parts, strict=True)]
    charts = [one for one in each if one is not None]
    if len(charts) < len(each):
        return None
    step = min(one.step for one in charts)
    factors = np.concatenate([np.full(one.size, one.step / step) for one in charts])
    ends = np.cumsum([one.size for one in charts])[:-1]

    def members(points: Floats) -> Members:
        pairs = zip(charts, np.split(factors * points, ends, axis=1), strict=True)
        parts = tuple(one.members(some) for one, some in pairs)
        return about._replace(tree=np.repeat(about.tree, len(points)), parts=parts)

    rooms = zip(*(one.room for one in charts), strict=True)
    low, high = (np.concatenate(room) / factors for room in rooms)
    return Coordinates(len(factors), step, members, (low, high))


def _of_space(genome: Any, about: Population) -> Coordinates:
    """Return coordinates: bounded numbers in halves of their range, others as logarithms."""
    space = genome.space()
    start = space.vectors(about)[0]
    bounded = np.isfinite(space.low) & np.isfinite(space.high)
    half = np.where(bounded, 0.5 * (space.high - space.low), 1.0)
    free = ~space.frozen

    def members(points: Floats) -> Members:
        moved = np.where(bounded, start + half * points, start * np.exp(np.clip(points, -FAR, FAR)))
        moved = np.clip(moved, space.low, space.high)
        return space.from_vectors(np.where(free, moved, start), about)

    with np.errstate(all="ignore"):
        ends = (space.low, space.high)
        room = [np.where(bounded, (x - start) / half, np.log(x / start)) for x in ends]
    low, high = (np.where(free, x, 0.0) for x in room)
    return Coordinates(len(start), STEP, members, (low, high))


def chain(genome: Genome, coordinates: Coordinates, point: Floats | float = 0.0) -> Floats:
    """Return the derivative of all floating-point gains by the coordinates, (gains, size)."""
    each = WIDTH * np.eye(coordinates.size)
    moved = (coordinates.members(point + x) for x in (each, -each))
    ahead, behind = (_numbers(genome, members) for members in moved)
    return (ahead - behind) / (2.0 * WIDTH)


def _numbers(genome: Genome, population: Population) -> Floats:
    """Return all floating-point gains of the individuals, (gains, n)."""
    leaves = jax.tree.leaves(genome.gains(population))
    count = len(population.tree)
    return np.concatenate([x.reshape(-1, count) for x in leaves if x.dtype.kind == "f"])
