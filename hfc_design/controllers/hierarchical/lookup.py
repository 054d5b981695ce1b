"""Graded of membership as a table, for machines without ``exp``, and what that costs."""

from typing import NamedTuple

import numpy as np

from hfc_design.controllers.hierarchical.law import outputs
from hfc_design.controllers.hierarchical.record import HierarchicalDesign
from hfc_design.controllers.hierarchical.unit import Graded, memberships
from hfc_design.core.scalars import ARRAYS
from hfc_design.core.shapes import Floats, Json


class Lookup(NamedTuple):
    """Graded of the seven terms, evenly spaced; linear in between and constant beyond."""

    points: int
    low: float
    high: float
    per_unit: float  # points in a unit of the normalised universe
    table: list[list[float]]  # (points, 7)
    deviation: float  # largest one found from the exact command


def tabulated(design: HierarchicalDesign, points: int) -> Json:
    """What the C template needs to go without ``exp``."""
    found = lookup(design, points)
    return {"lookup": found, "exponential": False, "deviation": found.deviation}


def lookup(design: HierarchicalDesign, points: int) -> Lookup:
    """The table over all values that an input or an earlier unit of ``design`` can take."""
    read = [0.0, *np.ravel([unit.consequents for unit in design.units[:-1]])]
    low, high = float(min(-1.0, *read)), float(max(1.0, *read))
    terms = design.layout().terms

    def exact(u: Floats) -> list[Floats]:
        return memberships(ARRAYS, terms, u)

    table = np.stack(exact(np.linspace(low, high, points)), axis=1)
    per_unit = (points - 1) / (high - low)

    def between(u: Floats) -> list[Floats]:
        place = np.clip((u - low) * per_unit, 0.0, points - 1)
        k = np.minimum(place.astype(int), points - 2)
        return list((table[k] + (place - k)[:, None] * (table[k + 1] - table[k])).T)

    found = _largest_deviation(design, exact, between)
    return Lookup(points, low, high, per_unit, table.tolist(), found)


def _largest_deviation(design: HierarchicalDesign, exact: Graded, other: Graded) -> float:
    """The largest difference of two commands that a search over the inputs finds.

    Random points miss the peaks, so the best of them climb: the steps halve in every round.
    """
    gains = design.gains()

    def deviations(inputs: Floats) -> Floats:
        roots = (outputs(ARRAYS, of, gains, list(inputs.T))[-1].output for of in (exact, other))
        return design.output_scale * np.abs(np.subtract(*roots))

    random = np.random.default_rng(0)
    size = len(design.inputs)
    inputs = random.uniform(-1.0, 1.0, (40_000, size))
    found, step = deviations(inputs), 0.1
    for _ in range(40):
        best = inputs[np.argsort(-found)[:200]]
        moves = step * random.standard_normal((8, *best.shape))
        inputs = np.concatenate([best, np.clip(best + moves, -1.0, 1.0).reshape(-1, size)])
        found, step = deviations(inputs), step * 0.8
    return float(found.max())
