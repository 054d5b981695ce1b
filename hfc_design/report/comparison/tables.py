"""A comparison in words and numbers, for the terminal and for the page."""

from collections.abc import Callable, Iterator, Sequence
from math import isfinite, isnan
from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import Floats, storable
from hfc_design.plotting.numbers import digits, metric, readable
from hfc_design.simulation.comparison import (
    HALF,
    NEARLY_ALL,
    SCORES,
    Comparison,
    DesignStatistics,
    Difference,
    MotionComparison,
)
from hfc_design.simulation.repeats import range_text

#: Text for a missing number.
NONE = "–"


class Line(NamedTuple):
    """A row of a table: a cell for each design."""

    metric: str  # "" where it is that of the row above
    of: str  # the machine
    cells: list[str]
    best: list[int]  # the designs that are the best here; none where all are alike

    @property
    def row(self) -> list[str]:
        """Cells of the row from left to right."""
        return [self.metric, self.of, *self.cells]

    @property
    def places(self) -> list[int]:
        """Places of the best cells in ``row``."""
        return [k + 2 for k in self.best]


def lines(bout: MotionComparison, every: bool = False) -> list[Line]:
    """Stability and metrics of the designs, the most important first.

    Each compared metric has the median machine, the first one also the nominal machine and the 95 %
    quantile; with ``every``, all metrics have all three.
    """
    sides = list(bout.sides.values())
    shares = [float(side.stable.mean()) for side in sides]
    ends = (side.interval for side in sides)
    intervals = [between(100 * low, 100 * high) for low, high in ends]
    texts = [
        Line("stable machines [%]", "all", [short(100 * x) for x in shares], best(shares, -1)),
        Line("", "interval", intervals, []),
    ]
    compared = bout.compared()
    for key in dict.fromkeys([*compared, *(bout.meanings if every else ())]):
        of = {
            "nominal": [side.of_nominal(key) for side in sides],
            "median": [side.quantile(key, HALF) for side in sides],
            "95 %": [side.quantile(key, NEARLY_ALL) for side in sides],
        }
        if all(value is None for values in of.values() for value in values):
            continue  # nobody has settled, say
        name, factor = titled(key, bout.meanings[key], of["nominal"] + of["median"])
        for what in of if every or key == compared[0] else ("median",):
            each = zip(of[what], sides, strict=True)
            cells = [_cell(value, factor, side, what, key) for value, side in each]
            texts.append(Line(name, what, cells, best(of[what], -1 if key in SCORES else 1)))
            name = ""
    return texts


def titled(key: str, meaning: str, values: Sequence[float | None]) -> tuple[str, float]:
    """Title of a metric with a unit for numbers of this size, and the factor to this unit.

    Its ``meaning`` ends with its unit; the ``meaning`` of a score is its title.
    """
    if key in SCORES:
        return meaning, 1.0
    sizes = [abs(x) for x in values if x and isfinite(x)]
    name, base = metric(key, meaning)
    factor, unit = readable(base, min(sizes, default=1.0))
    return f"{name} [{unit}]" if unit else name, factor


def called(bout: MotionComparison, key: str) -> str:
    """Title of a metric of a motion, without a unit."""
    return bout.meanings[key] if key in SCORES else metric(key, bout.meanings[key])[0]


def short(value: float) -> str:
    """A number with three digits, or all before the point."""
    return digits(value, 3)


def between(low: float, high: float, write: Callable[[float], str] = short) -> str:
    """Text of an interval."""
    return f"{write(low)}–{write(high)}"


def _cell(value: float | None, factor: float, side: DesignStatistics, what: str, key: str) -> str:
    if what == "nominal" and key in side.ranges:
        return range_text(side.ranges[key])
    if value is not None:
        return short(factor * value)
    share = {"median": HALF, "95 %": NEARLY_ALL}.get(what)
    stable = side.nominal_stable if share is None else side.stable.mean() >= share
    return NONE if stable else "unstable"


def best(values: Sequence[float | None], sign: int) -> list[int]:
    """Places of the least ``sign`` times a value; none if all are alike."""
    known = [sign * x for x in values if x is not None]
    if not known or (len(known) == len(values) and max(known) == min(known)):
        return []
    return [k for k, x in enumerate(values) if x is not None and sign * x == min(known)]


#: Heads of the columns of ``difference_row`` after the two designs.
DIFFERENCE_HEAD = ["median ratio", "better on", "p (Holm)", "both stable", "only one", "neither"]


def difference_row(one: Difference) -> list[str]:
    """A difference as a row of a table, after the names of the two designs."""
    low, high = (100.0 * x for x in one.better_interval)
    ratio = ratio_text(one.ratio)
    if one.ratio_interval:
        ratio += f" ({between(*one.ratio_interval, ratio_text)})"
    share = f"{one.better} of {one.machines} ({low:.0f}–{high:.0f} %)"
    only = f"{one.only_first}, {one.only_second}"
    return [ratio, share, p_text(one.p_holm), str(one.both), only, str(one.neither)]


def ratio_text(value: float) -> str:
    """Text of a ratio: 0 if only the first, infinite if only the second is stable."""
    if isnan(value):
        return NONE
    return f"{value:.3g}" if isfinite(value) else "∞"


def p_text(p: float) -> str:
    """Text of a probability."""
    return "< 0.0001" if p < 1e-4 else f"{p:.2g}"


def failures(comparison: Comparison) -> Iterator[str]:
    """Designs that are not stable on every machine, a line for each motion."""
    for bout in comparison.bouts:
        lost = {name: int((~side.stable).sum()) for name, side in bout.sides.items()}
        unstable = [
            f"{name} on {lost[name]}{'' if side.nominal_stable else ' and the nominal'}"
            for name, side in bout.sides.items()
            if lost[name] or not side.nominal_stable
        ]
        if unstable and bout.scenario:
            count = comparison.machines
            yield f"not stable in {bout.name}: {', '.join(unstable)} of {count} machines"


def rows(comparison: Comparison) -> list[list[object]]:
    """Every design on every machine in every motion, with a head; machine 0 is the nominal one."""
    bouts = [bout for bout in comparison.bouts if bout.scenario]
    keys = list(dict.fromkeys(key for bout in bouts for key in bout.meanings))
    drawn = {bout.name: _parameters(bout) for bout in bouts}
    names = list(dict.fromkeys(key for columns in drawn.values() for key in columns))
    table: list[list[object]] = [["design", "motion", "machine", "stable", *keys, *names]]
    for bout in bouts:
        cells = [drawn[bout.name].get(key) for key in names]
        for name, side in bout.sides.items():
            stable = [side.nominal_stable, *side.stable]
            columns = [
                np.append(side.nominal[key], side.values[key]) if key in side.values else None
                for key in keys
            ]
            for k, truth in enumerate(stable):
                numbers = (None if x is None else float(x[k]) for x in (*columns, *cells))
                table.append([name, bout.name, k, int(truth), *storable([*numbers])])
    return table


def _parameters(bout: MotionComparison) -> dict[str, Floats]:
    """Every parameter of the machines, (1 + machines,) each, the nominal machine first."""
    first = next(iter(bout.results.values()))
    each = zip(first.motion.axes, first.machines.actual, strict=True)
    several = len(first.machines.actual) > 1
    return {
        f"{axis.name}_{key}" if several else key: column
        for axis, record in each
        for key, column in record._asdict().items()
    }
