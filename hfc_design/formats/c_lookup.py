"""Degrees of membership as a table, for machines without ``exp``, and what that costs."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hfc_design.files.design import HierarchicalDesign

Floats = NDArray[np.float64]
Degrees = Callable[[Floats], Floats]  # (n,) -> (n, 7)


class Lookup(NamedTuple):
    """Degrees of the seven terms, evenly spaced; linear in between and constant beyond."""

    points: int
    low: float
    high: float
    per_unit: float  # points in a unit of the normalised universe
    table: list[list[float]]  # (points, 7)
    deviation: float  # largest one found from the exact command


def lookup(design: HierarchicalDesign, points: int) -> Lookup:
    """The table over all values that an input or an earlier unit of ``design`` can take."""
    read = [0.0, *np.ravel([unit.consequents for unit in design.units[:-1]])]
    low, high = float(min(-1.0, *read)), float(max(1.0, *read))
    exact = _exact(design)
    table = exact(np.linspace(low, high, points))
    per_unit = (points - 1) / (high - low)

    def tabulated(u: Floats) -> Floats:
        place = np.clip((u - low) * per_unit, 0.0, points - 1)
        k = np.minimum(place.astype(int), points - 2)
        return table[k] + (place - k)[:, None] * (table[k + 1] - table[k])

    found = _largest_deviation(design, exact, tabulated)
    return Lookup(points, low, high, per_unit, table.tolist(), found)


def _exact(design: HierarchicalDesign) -> Degrees:
    """Degrees in the design's terms (LL eq. 3)."""
    centres, half_widths, rates = np.array(
        [(term.centre, term.half_width, term.rate) for term in design.terms]
    ).T

    def degrees(u: Floats) -> Floats:
        distance = np.maximum(np.abs(u[:, None] - centres) - half_widths, 0.0)
        return np.exp(-rates * distance * distance)

    return degrees


def _fuzzy_command(design: HierarchicalDesign, degrees: Degrees, inputs: Floats) -> Floats:
    """What the units add to the command, (n,), at scaled ``inputs`` (n, inputs)."""
    values = list(inputs.T)
    for unit, (column, row) in zip(design.units, design.sources(), strict=True):
        in_column, in_row = degrees(values[column]), degrees(values[row])
        firing = in_column.sum(1) * in_row.sum(1)
        weighted = ((in_row @ np.array(unit.consequents)) * in_column).sum(1)
        values.append(weighted / np.where(firing > 0.0, firing, 1.0))
    return design.output_scale * values[-1]


def _largest_deviation(design: HierarchicalDesign, exact: Degrees, other: Degrees) -> float:
    """The largest difference of two commands that a search over the inputs finds.

    Random points miss the peaks, so the best of them climb: the steps halve in every round.
    """

    def deviations(inputs: Floats) -> Floats:
        commands = (_fuzzy_command(design, degrees, inputs) for degrees in (exact, other))
        return np.abs(np.subtract(*commands))

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
