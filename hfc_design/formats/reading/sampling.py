"""A rule base of any kind as a table of triangles: the output at the centres, straight between."""

from itertools import product
from typing import NamedTuple

import numpy as np

from hfc_design.controllers.flc.rules import FEWEST, LABELS, MOST
from hfc_design.core.numbers import Floats, Json
from hfc_design.core.records import TERMS
from hfc_design.core.wording import percent
from hfc_design.formats.reading.fitting import SAME, Side, core, fitted, straight
from hfc_design.formats.reading.inference import RuleBase, Variable
from hfc_design.formats.reading.system import Input, Output, Singleton, System, input_of, shape_of

#: Points a side at which table and original are compared, and of these one in so many at which a
#: centre can lie, beside the places of the file's terms.
POINTS, COARSE = 201, 2
#: So many pairs of terms without a rule are named.
NAMED = 3
#: A range of an input that can be sampled, and its width in shares of that.
LARGEST, SMALLEST = 1e9, 1e-15
#: What is smaller, in shares of the largest output, is a 0 that was rounded.
ROUNDING = 1e-13


class Sampled(NamedTuple):
    """A table and how far it is from what it was made of."""

    system: System
    told: Json  # for the design's provenance


@np.errstate(over="ignore", invalid="ignore")  # of any number in a file
def sampled(base: RuleBase, wanted: tuple[int, int] | None) -> Sampled:
    """The table with ``wanted`` terms of each input, or as many as the file has.

    Raises:
        ValueError: a range is not finite, or there are values for which no rule fires.
    """
    counts = wanted or [min(max(len(v.terms), FEWEST), MOST) for v in base.inputs]
    sides = [_side(*pair) for pair in zip(base.inputs, counts, strict=True)]
    grid = _on(base, sides[0].values, sides[1].values)
    centres = fitted(grid, sides, base.inputs)
    x, y = (side.values[places] for side, places in zip(sides, centres, strict=True))
    table = grid[np.ix_(*centres)]
    off = np.abs(straight(sides[0].values, x) @ table @ straight(sides[1].values, y).T - grid)
    # In a table that is alike on either side of 0 the first of both places.
    row, column = np.argwhere(off >= (1.0 - SAME) * off.max())[0]
    names = [variable.name.text for variable in base.inputs]
    at = (sides[0].values[row], sides[1].values[column])
    told = {
        "terms": f"{len(x)} x {len(y)}",
        "largest_deviation": float(off.max()),
        "at": dict(zip(names, map(float, at), strict=True)),
        "output_range": [float(grid.min()), float(grid.max())],
        "points": f"{len(sides[0].values)} x {len(sides[1].values)}",
    }
    if pairs := base.left_out():
        told["without_rule"] = pairs
    inputs = _input(base.inputs[0], x), _input(base.inputs[1], y)
    labels = [term.label.text for term in base.output.terms]
    output = Output(base.output.name.text, base.output.low, base.output.high, labels)
    system = System(base.name, inputs, output, {}, notes=base.notes)
    for i, j in product(range(len(x)), range(len(y))):
        system.add(base.output.name, (i, j), Singleton("", float(table[i, j])))
    return Sampled(system, told)


def deviation_told(told: Json, chosen: bool) -> str:
    """The largest deviation of a table in a line: where it is, and of how many points.

    Where nobody has ``chosen`` the number of terms, it says that there could be more.
    """
    low, high = told["output_range"]
    most = told["largest_deviation"]
    share = f" ({percent(most / (high - low))} of its range)" if high > low else ""
    at = ", ".join(f"{name} = {value:.4g}" for name, value in told["at"].items())
    more = f"; more terms, --terms up to {MOST}, usually make that smaller"
    full = chosen or most == 0.0 or told["terms"] == f"{MOST} x {MOST}"
    return (
        f"sampled to {told['terms']} terms: output off by {most:.3g} at most{share}, at {at}; "
        f"of {told['points']} points{'' if full else more}"
    )


def left_out_told(told: Json) -> str:
    """Which pairs of terms have no rule, in a line; "": all have one."""
    pairs = told.get("without_rule", [])
    if not pairs:
        return ""
    more = f" and {len(pairs) - NAMED} more pairs" if len(pairs) > NAMED else ""
    return f"no rule for {'; '.join(pairs[:NAMED])}{more}: there the rules beside them decide"


def _side(variable: Variable, count: int) -> Side:
    low, high = variable.low, variable.high
    name = variable.name.text
    if not (max(abs(low), abs(high)) <= LARGEST and high - low >= SMALLEST * LARGEST):
        told = f"its range has to lie within {-LARGEST:g} and {LARGEST:g} and not be a point"
        raise variable.name.fault(f"input {name}: {told}")
    marks = [place for term in variable.terms for place in term.places if low < place < high]
    marks += [0.0] if low < 0.0 < high else []
    even = _short(np.linspace(low, high, POINTS))
    values = np.unique(np.concatenate([even, marks]))
    allowed = np.flatnonzero(np.isin(values, np.concatenate([even[::COARSE], marks])))
    held = count // 2 if low < 0.0 < high and count % 2 else None
    return Side(values, allowed, count, held)


def _short(values: Floats) -> Floats:
    """Evenly spaced values without the digits that rounding adds; the ends stay."""
    digits = 12 - int(np.floor(np.log10(np.ptp(values))))
    rounded = np.round(values, min(digits, 300))
    rounded[[0, -1]] = values[[0, -1]]
    return np.asarray(rounded)


def _on(base: RuleBase, x: Floats, y: Floats) -> Floats:
    """Outputs on a grid; ValueError: there is none at one of its points."""
    first, second = (part.ravel() for part in np.meshgrid(x, y, indexing="ij"))
    found = base.outputs(first, second).reshape(len(x), len(y))
    found[np.abs(found) < ROUNDING * np.abs(found).max()] = 0.0
    bad = np.argwhere(~np.isfinite(found))
    if len(bad):
        a, b = (variable.name.text for variable in base.inputs)
        i, j = bad[0]
        raise ValueError(f"no rule fires at {a} = {x[i]:g}, {b} = {y[j]:g}: there is no output")
    return np.asarray(found)


def _input(variable: Variable, centres: Floats) -> Input:
    grid = np.linspace(variable.low, variable.high, POINTS)
    cores = [float(grid[core(term.degree(grid))]) for term in variable.terms]
    order = sorted(range(len(cores)), key=cores.__getitem__)
    own = [variable.terms[k].label.text for k in order]
    labels = _labels(own, [float(x) for x in centres])
    shapes = []
    for k, label in enumerate(labels):
        token = variable.name._replace(text=label)
        near = [float(x) for x in centres[max(k - 1, 0) : k + 2]]
        letters = "--ab" if k == 0 else "ab++" if k + 1 == len(labels) else "abbc"
        shapes.append(shape_of(token, "", letters, near))
    return input_of(variable.name, variable.low, variable.high, shapes)


def _labels(own: list[str], centres: list[float]) -> list[str]:
    """The file's own where they are as many; else numbers, beside 0 with their sign."""
    if len(own) == len(centres):
        return own
    half = len(centres) // 2
    if len(centres) % 2 == 0 or centres[half] != 0.0:
        return [f"T{k}" for k in range(1, len(centres) + 1)]
    if len(centres) == TERMS:
        return list(LABELS)
    below, above = ([f"{side}{k}" for k in range(1, half + 1)] for side in "NP")
    return [*reversed(below), "ZR", *above]
