"""Lookup table of degrees, for processors without ``exp``, and how much it changes the output."""

from functools import partial
from typing import NamedTuple

import numpy as np

from hfc_design.controllers.hierarchical.law import Graded, Grid, hierarchical, memberships, outputs
from hfc_design.controllers.hierarchical.record import HierarchicalDesign, layout_of
from hfc_design.core.numbers import ARRAYS, Floats, Json


class Lookup(NamedTuple):
    """Lookup table of the degrees in seven terms; linear between points and constant beyond."""

    points: int
    low: float
    high: float
    per_unit: float  # number of points in an interval of length 1
    table: list[list[float]]  # (points, 7)
    deviation: float  # largest error found of the quantity ``of``
    largest: float  # largest magnitude found of the quantity ``of``
    of: str = "command"


def tabulated(design: HierarchicalDesign, points: int) -> Json:
    """Return by key the law with a lookup table of ``points`` values, and how far it deviates."""
    lookup_table = lookup(design, points)
    grid = Grid(lookup_table.low, lookup_table.per_unit, tuple(map(tuple, lookup_table.table)))
    layout = layout_of(design)._replace(grid=grid)
    return {
        "deviation": lookup_table.deviation,
        "deviates": lookup_table.of,
        "largest": lookup_table.largest,
        "law": partial(hierarchical, layout, design.sample_time_s),
    }


def lookup(design: HierarchicalDesign, points: int) -> Lookup:
    """Return the lookup table over all values that a unit of ``design`` can read."""
    read = [0.0, *np.ravel([unit.consequents for unit in design.units[:-1]])]
    low, high = float(min(-1.0, *read)), float(max(1.0, *read))
    terms = layout_of(design).terms

    def exact(u: Floats) -> list[Floats]:
        return memberships(ARRAYS, terms, u)

    table = np.stack(exact(np.linspace(low, high, points)), axis=1)
    per_unit = (points - 1) / (high - low)

    def between(u: Floats) -> list[Floats]:
        place = np.clip((u - low) * per_unit, 0.0, points - 1)
        k = np.minimum(place.astype(int), points - 2)
        return list((table[k] + (place - k)[:, None] * (table[k + 1] - table[k])).T)

    deviation, largest = _largest_deviation(design, exact, between)
    # If the hierarchy multiplies a law, its output is a factor and no command.
    of = "factor of the scheduled law" if design.scheduled else "command"
    return Lookup(points, low, high, per_unit, table.tolist(), deviation, largest, of)


def _largest_deviation(
    design: HierarchicalDesign, exact: Graded, other: Graded
) -> tuple[float, float]:
    """Return the largest difference found between scaled outputs with two kinds of degrees.

    The second number is the largest magnitude of the output with ``exact`` degrees, at random
    inputs. Random inputs miss the peaks of the difference, so those with the largest difference
    are refined by random steps that shrink in every round.
    """
    gains, source_options = design.law_gains(), layout_of(design).input_range

    def root(degrees: Graded, inputs: Floats) -> Floats:
        output = outputs(ARRAYS, degrees, source_options, gains, list(inputs.T))[0][-1].output
        return design.output_scale * np.asarray(output)

    def deviations(inputs: Floats) -> Floats:
        return np.abs(root(exact, inputs) - root(other, inputs))

    random = np.random.default_rng(0)
    size = len(design.inputs)
    inputs = random.uniform(-1.0, 1.0, (40_000, size))
    largest = float(np.abs(root(exact, inputs)).max())
    differences, step = deviations(inputs), 0.1
    for _ in range(40):
        best = inputs[np.argsort(-differences)[:200]]
        moves = step * random.standard_normal((8, *best.shape))
        inputs = np.concatenate([best, np.clip(best + moves, -1.0, 1.0).reshape(-1, size)])
        differences, step = deviations(inputs), step * 0.8
    return float(differences.max()), largest
