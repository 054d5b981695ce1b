"""Lookup table of degrees, for processors without ``exp``, and how much it changes the output."""

from functools import partial

import numpy as np

from hfc_design.controllers.hierarchical.law import Graded, Grid, hierarchical, memberships, outputs
from hfc_design.controllers.hierarchical.record import HierarchicalDesign, layout_of
from hfc_design.core.numbers import ARRAYS, Floats, Json


def tabulated(design: HierarchicalDesign, points: int) -> Json:
    """Return by key the law with a lookup table of ``points`` values, and how far it deviates.

    The table covers all values that a unit of ``design`` can read. "deviation" and "largest" are
    the largest error and the largest magnitude found of the quantity "deviates".
    """
    read = [0.0, *np.ravel([unit.consequents for unit in design.units[:-1]])]
    low, high = float(min(-1.0, *read)), float(max(1.0, *read))
    layout = layout_of(design)

    def exact(u: Floats) -> list[Floats]:
        return memberships(ARRAYS, layout.terms, u)

    table = np.stack(exact(np.linspace(low, high, points)), axis=1)
    per_unit = (points - 1) / (high - low)

    def between(u: Floats) -> list[Floats]:
        place = np.clip((u - low) * per_unit, 0.0, points - 1)
        k = np.minimum(place.astype(int), points - 2)
        return list((table[k] + (place - k)[:, None] * (table[k + 1] - table[k])).T)

    deviation, largest = _largest_deviation(design, exact, between)
    grid = Grid(low, per_unit, tuple(map(tuple, table.tolist())))
    return {
        "deviation": deviation,
        # If the hierarchy multiplies a law, its output is a factor and no command.
        "deviates": "factor of the scheduled law" if design.scheduled else "command",
        "largest": largest,
        "law": partial(hierarchical, layout._replace(grid=grid), design.sample_time_s),
    }


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
