"""Sampling of any rule base as a table of triangles: its output at the centres, linear in between.

The centres are placed so that the table deviates least from the original. They move one by one,
once from even spacing and once from the centres of the file's terms. If the original is odd, with
f(-x, -y) = c - f(x, y), they move in pairs, so that the table is odd as well.
"""

from collections.abc import Iterator
from itertools import product
from typing import NamedTuple

import numpy as np

from hfc_design.controllers.flc.rules import FEWEST, LABELS, MOST
from hfc_design.core.numbers import Floats, Integers, Json
from hfc_design.core.records import TERMS
from hfc_design.core.wording import percent
from hfc_design.formats.reading.inference import RuleBase, Variable
from hfc_design.formats.reading.system import Input, Output, Singleton, System, input_of, shape_of

#: Number of points of each input at which table and original are compared. Every ``COARSE``-th of
#: them can be a centre, and so can the corners of the file's terms.
POINTS, COARSE = 201, 2
#: Number of pairs of terms without a rule that are listed.
NAMED = 3
#: Largest magnitude in a range that can be sampled; least width as a share of ``LARGEST``.
LARGEST, SMALLEST = 1e9, 1e-15
#: Outputs below this share of the largest output count as 0, as rounding errors.
ROUNDING = 1e-13


#: How often the deviations are squared, so that the largest decide.
SQUARED = 3
#: Largest number of passes in which every centre is moved.
SWEEPS = 12
#: Least difference that counts, as a share of the largest output or of a range.
SAME = 1e-9


class Side(NamedTuple):
    """Input on a grid."""

    values: Floats  # (points,) from the lowest to the highest of its range
    allowed: Integers  # indices in ``values`` at which a centre can lie
    centres: int  # number of centres
    centre_place: int | None  # index of the centre that stays on 0; None: none does


def fitted(
    grid: Floats, sides: list[Side], inputs: tuple[Variable, Variable]
) -> tuple[Integers, Integers]:
    """Return the indices of the centres in the values of both sides; ``grid`` is the output."""
    coarse = grid[np.ix_(sides[0].allowed, sides[1].allowed)]
    scale = float(np.ptp(coarse)) or 1.0
    axes = [side.values[side.allowed] for side in sides]
    odd = _is_odd(coarse / scale, axes)
    starts = [[_even(side, axis) for side, axis in zip(sides, axes, strict=True)]]
    starts_of = [_cores(*each) for each in zip(sides, axes, inputs, strict=True)]
    starts += [[starts_of[0], starts_of[1]]] if starts_of[0] and starts_of[1] else []
    tried = [_moved(coarse / scale, axes, start, sides, odd) for start in starts]
    best = tried[-1][1] if _less(tried[-1][0], tried[0][0]) else tried[0][1]
    return sides[0].allowed[best[0]], sides[1].allowed[best[1]]


def _is_odd(grid: Floats, axes: list[Floats]) -> bool:
    """True if ranges are symmetric, and opposite outputs have the same sum everywhere."""
    twice = grid + grid[::-1, ::-1]
    ends = [np.abs(axis + axis[::-1]).max() <= SAME * np.ptp(axis) for axis in axes]
    return all(ends) and float(np.ptp(twice)) <= SAME


def _even(side: Side, axis: Floats) -> list[int]:
    """Return indices of evenly spaced centres; if one stays on 0, evenly on each side of it."""
    if side.centre_place is None:
        wanted = np.linspace(axis[0], axis[-1], side.centres)
    else:
        half = side.centres // 2 + 1
        below, above = np.linspace(axis[0], 0.0, half), np.linspace(0.0, axis[-1], half)
        wanted = np.concatenate([below, above[1:]])
    return _different([int(np.abs(axis - value).argmin()) for value in wanted], len(axis))


def _cores(side: Side, axis: Floats, variable: Variable) -> list[int]:
    """Return indices of the peaks of the file's terms; [] if they cannot be the centres."""
    cores = sorted({core(term.degree(axis)) for term in variable.terms})
    if len(cores) != side.centres or (
        side.centre_place is not None and axis[cores[side.centre_place]] != 0.0
    ):
        return []
    return cores


def core(degree: Floats) -> int:
    """Return the index of a peak: the middle of a flat top, or its inner end at the edge."""
    highest = np.flatnonzero(degree >= (1.0 - SAME) * degree.max())
    first, last = int(highest[0]), int(highest[-1])
    if first == 0 or last == len(degree) - 1:
        return last if first == 0 else first
    return (first + last) // 2


def _different(places: list[int], count: int) -> list[int]:
    """Return the indices, changed so that they ascend and stay below ``count``."""
    for k in range(1, len(places)):
        places[k] = max(places[k], places[k - 1] + 1)
    for k in range(len(places) - 1, -1, -1):
        places[k] = min(places[k], count - len(places) + k)
    return places


def _moved(
    grid: Floats, axes: list[Floats], places: list[list[int]], sides: list[Side], odd: bool
) -> tuple[float, list[list[int]]]:
    """Return the least deviation that moving one centre at a time finds, and the centres."""
    counts = [len(axis) for axis in axes]
    places = [
        _paired(chosen, count) if odd else [*chosen]
        for chosen, count in zip(places, counts, strict=True)
    ]
    within = [straight(axis, axis[chosen]) for axis, chosen in zip(axes, places, strict=True)]
    least = _deviation(grid, within, places)
    for _ in range(SWEEPS):
        before = least
        for side in (0, 1):
            moving = range(len(places[side]) // 2 if odd else len(places[side]))
            for k in moving:
                if k == sides[side].centre_place:
                    continue
                for tried in _tries(places[side], k, counts[side], odd):
                    trial = [*within]
                    trial[side] = straight(axes[side], axes[side][tried])
                    both = [*places]
                    both[side] = tried
                    if _less(deviation := _deviation(grid, trial, both), least):
                        least, within, places = deviation, trial, both
        if least >= before:
            break
    return least, places


def _tries(chosen: list[int], k: int, count: int, odd: bool) -> Iterator[list[int]]:
    """Yield the indices of centres with centre ``k`` at each place between its neighbours."""
    low = chosen[k - 1] + 1 if k else 0
    high = chosen[k + 1] if k + 1 < len(chosen) else count
    for place in range(low, min(high, count // 2) if odd else high):
        tried = [*chosen[:k], place, *chosen[k + 1 :]]
        yield _paired(tried, count) if odd else tried


def _paired(places: list[int], count: int) -> list[int]:
    """Return the indices with the upper half as the mirror image of the lower half."""
    half = len(places) // 2
    return [*places[: len(places) - half], *(count - 1 - place for place in places[:half][::-1])]


def _less(one: float, other: float) -> bool:
    """True if one deviation is less than another by more than rounding."""
    return one < (1.0 - SAME) * other and other > SAME ** (2**SQUARED)


def _deviation(grid: Floats, within: list[Floats], places: list[list[int]]) -> float:
    table = grid[np.ix_(*places)]
    off = within[0] @ table @ within[1].T - grid
    for _ in range(SQUARED):
        off = off * off
    return float(np.mean(off))


def straight(values: Floats, centres: Floats) -> Floats:
    """Return degrees (values, centres) of triangles between the centres, flat at both ends."""
    return np.stack([np.interp(values, centres, unit) for unit in np.eye(len(centres))], axis=1)


@np.errstate(over="ignore", invalid="ignore")  # a file may have any number
def compared_on(base: RuleBase, wanted: tuple[int, int] | None) -> tuple[list[Side], Floats]:
    """Return both inputs on a grid, and the output there, to compare a table with it.

    Raises:
        ValueError: a range is not finite, or there are values for which no rule fires.
    """
    counts = wanted or [min(max(len(v.terms), FEWEST), MOST) for v in base.inputs]
    sides = [_side(*pair) for pair in zip(base.inputs, counts, strict=True)]
    return sides, _on(base, sides[0].values, sides[1].values)


@np.errstate(over="ignore", invalid="ignore")
def sampled(base: RuleBase, wanted: tuple[int, int] | None) -> tuple[System, Json]:
    """Return a table with ``wanted`` terms for each input, or with as many as the file has.

    The second result is a report for the provenance of a design: how far the table deviates.

    Raises:
        ValueError: as for ``compared_on``.
    """
    sides, grid = compared_on(base, wanted)
    centres = fitted(grid, sides, base.inputs)
    x, y = (side.values[places] for side, places in zip(sides, centres, strict=True))
    table = grid[np.ix_(*centres)]
    off = np.abs(straight(sides[0].values, x) @ table @ straight(sides[1].values, y).T - grid)
    # If several points deviate most, as in a symmetric table, the first one is reported.
    row, column = np.argwhere(off >= (1.0 - SAME) * off.max())[0]
    names = [variable.name.text for variable in base.inputs]
    at = (sides[0].values[row], sides[1].values[column])
    report: Json = {"terms": f"{len(x)} x {len(y)}", "largest_deviation": float(off.max())}
    report["at"] = dict(zip(names, map(float, at), strict=True))
    report["output_range"] = [float(grid.min()), float(grid.max())]
    report["points"] = f"{len(sides[0].values)} x {len(sides[1].values)}"
    if pairs := base.left_out():
        report["without_rule"] = pairs
    inputs = _input(base.inputs[0], x), _input(base.inputs[1], y)
    labels = [term.label.text for term in base.output.terms]
    output = Output(base.output.name.text, base.output.low, base.output.high, labels)
    system = System(base.name, inputs, output, {}, notes=base.notes)
    for i, j in product(range(len(x)), range(len(y))):
        system.add(base.output.name, (i, j), Singleton("", float(table[i, j])))
    return system, report


def deviation_told(report: Json, chosen: bool) -> str:
    """Return a line on the largest deviation of a table, with its place and the number of points.

    If the number of terms was not ``chosen`` by the user, the line says that there could be more.
    """
    low, high = report["output_range"]
    most = report["largest_deviation"]
    share = f" ({percent(most / (high - low))} of its range)" if high > low else ""
    at = ", ".join(f"{name} = {value:.4g}" for name, value in report["at"].items())
    more = f"; more terms, --terms up to {MOST}, usually reduce this"
    full = chosen or most == 0.0 or report["terms"] == f"{MOST} x {MOST}"
    return (
        f"sampled to {report['terms']} terms: output deviates by at most {most:.3g}{share}, "
        f"at {at}; compared at {report['points']} points{'' if full else more}"
    )


def left_out_told(report: Json) -> str:
    """Return a line on the pairs of terms that have no rule; "" if all pairs have one."""
    pairs = report.get("without_rule", [])
    if not pairs:
        return ""
    more = f" and {len(pairs) - NAMED} more pairs" if len(pairs) > NAMED else ""
    return f"no rule for {'; '.join(pairs[:NAMED])}{more}: there the neighbouring rules decide"


def _side(variable: Variable, count: int) -> Side:
    low, high = variable.low, variable.high
    name = variable.name.text
    if not (max(abs(low), abs(high)) <= LARGEST and high - low >= SMALLEST * LARGEST):
        message = f"its range must be between {-LARGEST:g} and {LARGEST:g} and not empty"
        raise variable.name.fault(f"input {name}: {message}")
    marks = [place for term in variable.terms for place in term.places if low < place < high]
    marks += [0.0] if low < 0.0 < high else []
    even = _short(np.linspace(low, high, POINTS))
    values = np.unique(np.concatenate([even, marks]))
    allowed = np.flatnonzero(np.isin(values, np.concatenate([even[::COARSE], marks])))
    centre = count // 2 if low < 0.0 < high and count % 2 else None
    return Side(values, allowed, count, centre)


def _short(values: Floats) -> Floats:
    """Return evenly spaced values without the digits that rounding adds; the ends stay."""
    digits = 12 - int(np.floor(np.log10(np.ptp(values))))
    rounded = np.round(values, min(digits, 300))
    rounded[[0, -1]] = values[[0, -1]]
    return np.asarray(rounded)


def _on(base: RuleBase, x: Floats, y: Floats) -> Floats:
    """Return the outputs (x, y) on a grid; ValueError: no rule fires at one of its points."""
    first, second = (part.ravel() for part in np.meshgrid(x, y, indexing="ij"))
    surface = base.outputs(first, second).reshape(len(x), len(y))
    surface[np.abs(surface) < ROUNDING * np.abs(surface).max()] = 0.0
    bad = np.argwhere(~np.isfinite(surface))
    if len(bad):
        a, b = (variable.name.text for variable in base.inputs)
        i, j = bad[0]
        raise ValueError(f"no rule fires at {a} = {x[i]:g}, {b} = {y[j]:g}: there is no output")
    return np.asarray(surface)


def _input(variable: Variable, centres: Floats) -> Input:
    grid = np.linspace(variable.low, variable.high, POINTS)
    cores = [float(grid[core(term.degree(grid))]) for term in variable.terms]
    order = sorted(range(len(cores)), key=cores.__getitem__)
    texts = [variable.terms[k].label.text for k in order]
    labels = _labels(texts, [float(x) for x in centres])
    shapes = []
    for k, label in enumerate(labels):
        token = variable.name._replace(text=label)
        near = [float(x) for x in centres[max(k - 1, 0) : k + 2]]
        letters = "--ab" if k == 0 else "ab++" if k + 1 == len(labels) else "abbc"
        shapes.append(shape_of(token, "", letters, near))
    return input_of(variable.name, variable.low, variable.high, shapes)


def _labels(given: list[str], centres: list[float]) -> list[str]:
    """Return labels: the file's if there are as many, else T1, T2, ..., or names with ZR at 0."""
    if len(given) == len(centres):
        return given
    half = len(centres) // 2
    if len(centres) % 2 == 0 or centres[half] != 0.0:
        return [f"T{k}" for k in range(1, len(centres) + 1)]
    if len(centres) == TERMS:
        return list(LABELS)
    below, above = ([f"{side}{k}" for k in range(1, half + 1)] for side in "NP")
    return [*reversed(below), "ZR", *above]
