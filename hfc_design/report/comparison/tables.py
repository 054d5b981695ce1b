"""A comparison in words and numbers, for the terminal and for the page."""

from collections.abc import Callable, Iterator, Sequence
from math import isfinite, isnan

import numpy as np

from hfc_design.core.numbers import Floats, storable
from hfc_design.core.tables import MISSING, Table, text
from hfc_design.core.wording import three_digits
from hfc_design.plotting.numbers import metric, readable
from hfc_design.simulation.comparison import (
    HALF,
    NEARLY_ALL,
    SCORES,
    Comparison,
    DesignStatistics,
    Difference,
    MotionComparison,
    spread_text,
)
from hfc_design.simulation.repeats import range_text

#: Heads of the columns of ``difference_row`` after the two designs.
DIFFERENCE_HEAD = ["median ratio", "better on", "p (Holm)", "both stable", "only one", "neither"]
#: Number of columns of a ``difference_table`` that fit a terminal.
FIRST = 5
#: Explanation of ``DIFFERENCE_HEAD``; the number of all comparisons is inserted.
DIFFERENCES = (
    "median ratio of the first to the second with an interval of 95 %, share on which the first is "
    "better, p of Wilcoxon’s signed-rank test after Holm’s correction for all {} comparisons, and "
    "on how many machines both, only one and neither are stable"
)
MAIN = (
    "the median of each metric over {}; for the first also the nominal machine and the 95th "
    "percentile"
)
EVERY = "every metric on the nominal machine, its median over {}, and their 95th percentile"
BEST = "* the best of a row; an unstable machine ranks below all others"


def tables(comparison: Comparison) -> list[Table]:
    """Return tables of every motion, then the differences of the first design from the others."""
    keys = ((bout, key) for bout in comparison.bouts for key in bout.compared())
    differences = [
        difference_table(comparison, bout, key)
        for bout, key in keys
        if key == bout.compared()[0] or "_change" in key
    ]
    shown = [
        one._replace(head=one.head[:FIRST], rows=[x[:FIRST] for x in one.rows])
        for one in differences
    ]
    *others, last = [metric_table(comparison, bout) for bout in comparison.bouts]
    notes = text(*failures(comparison), *comparison.notes)
    return [*others, last._replace(lines=[BEST]), *shown, notes]


def metric_table(comparison: Comparison, bout: MotionComparison, every: bool = False) -> Table:
    """Return a table of ``metric_rows``, a column for each design."""
    rows, places = metric_rows(bout, every)
    machines = f"{comparison.machines} machines within {comparison.within}"
    caption = f"{bout.name}: {(EVERY if every else MAIN).format(machines)}"
    robust = bout.scenario.robust if bout.scenario else None
    if robust and (within := spread_text(robust.spread, robust.tolerances)) != comparison.within:
        machines += f" ([robust]: {within})"
    head, title = ["metric", "machine", *comparison.designs], f"{bout.name}, {machines}"
    return Table(caption, head, rows, places, title)


def metric_rows(
    bout: MotionComparison, every: bool = False
) -> tuple[list[list[str]], list[list[int]]]:
    """Return rows with stability and metrics of the designs, and the indices of the best cells.

    Each compared metric has the median machine, the first one also the nominal machine and the 95 %
    quantile; with ``every``, all metrics have all three. A row is the metric ("": that of the row
    above), the machine, and a cell for each design.
    """
    sides = list(bout.sides.values())
    shares = [float(side.stable.mean()) for side in sides]
    ends = (side.interval for side in sides)
    intervals = [between(100 * low, 100 * high) for low, high in ends]
    rows = [
        ["stable machines [%]", "all", *(three_digits(100 * x) for x in shares)],
        ["", "interval", *intervals],
    ]
    places = [best(shares, -1), []]
    compared = bout.compared()
    for key in dict.fromkeys([*compared, *(bout.meanings if every else ())]):
        of = {
            "nominal": [side.of_nominal(key) for side in sides],
            "median": [side.quantile(key, HALF) for side in sides],
            "95 %": [side.quantile(key, NEARLY_ALL) for side in sides],
        }
        if all(value is None for values in of.values() for value in values):
            continue  # no design has settled, for example
        name, factor = titled(key, bout.meanings[key], of["nominal"] + of["median"])
        for what in of if every or key == compared[0] else ("median",):
            each = zip(of[what], sides, strict=True)
            rows.append(
                [name, what, *(_cell(value, factor, side, what, key) for value, side in each)]
            )
            places.append(best(of[what], -1 if key in SCORES else 1))
            name = ""
    return rows, [[k + 2 for k in some] for some in places]


def titled(key: str, meaning: str, values: Sequence[float | None]) -> tuple[str, float]:
    """Return the title of a metric with a unit that suits ``values``, and the factor to this unit.

    The ``meaning`` of a metric ends with its unit; the ``meaning`` of a score is its title.
    """
    if key in SCORES:
        return meaning, 1.0
    sizes = [abs(x) for x in values if x and isfinite(x)]
    name, base = metric(key, meaning)
    factor, unit = readable(base, min(sizes, default=1.0))
    return f"{name} [{unit}]" if unit else name, factor


def called(bout: MotionComparison, key: str) -> str:
    """Return the title of a metric of a motion, without a unit."""
    return bout.meanings[key] if key in SCORES else metric(key, bout.meanings[key])[0]


def between(low: float, high: float, write: Callable[[float], str] = three_digits) -> str:
    """Return the text of an interval."""
    return f"{write(low)}–{write(high)}"


def _cell(value: float | None, factor: float, side: DesignStatistics, what: str, key: str) -> str:
    if what == "nominal" and key in side.ranges:
        return range_text(side.ranges[key])
    if value is not None:
        return three_digits(factor * value)
    share = {"median": HALF, "95 %": NEARLY_ALL}.get(what)
    stable = side.nominal_stable if share is None else side.stable.mean() >= share
    return MISSING if stable else "unstable"


def best(values: Sequence[float | None], sign: int) -> list[int]:
    """Return the indices of the least ``sign`` times value; none if all values are equal."""
    known = [sign * x for x in values if x is not None]
    if not known or (len(known) == len(values) and max(known) == min(known)):
        return []
    return [k for k, x in enumerate(values) if x is not None and sign * x == min(known)]


def difference_table(comparison: Comparison, bout: MotionComparison, key: str) -> Table:
    """Return a table of the differences of the first design from the others in a metric."""
    first = next(iter(comparison.designs))
    rows = [
        [one.second, *difference_row(one)]
        for one in comparison.of(bout.name, key)
        if one.first == first
    ]
    title, name = f"{bout.name}, {called(bout, key)}: {first} over", called(bout, key)
    machines = f"on {comparison.machines} machines within {comparison.within}"
    about = f"{bout.name}: {name} of {first}, the first, and each other design {machines}: "
    caption = about + DIFFERENCES.format(len(comparison.differences))
    return Table(caption, ["over", *DIFFERENCE_HEAD], rows, title=title)


def other_differences(comparison: Comparison, bout: MotionComparison) -> Table:
    """Return all differences in a motion that its first ``difference_table`` does not have."""
    main, first = bout.compared()[0], next(iter(comparison.designs))
    rows = [
        [x.first, x.second, called(bout, x.metric), *difference_row(x)]
        for x in comparison.differences
        if x.motion == bout.name and (x.metric, x.first) != (main, first)
    ]
    machines = f"{comparison.machines} machines within {comparison.within}"
    caption = f"{bout.name}: every other pair and metric on {machines}"
    key = f": {DIFFERENCES.format(len(comparison.differences))}"
    return Table(caption, ["first", "second", "metric", *DIFFERENCE_HEAD], rows, key=key)


def difference_row(one: Difference) -> list[str]:
    """Return the cells ``DIFFERENCE_HEAD`` of a difference."""
    low, high = (100.0 * x for x in one.better_interval)
    ratio = ratio_text(one.ratio)
    if one.ratio_interval:
        ratio += f" ({between(*one.ratio_interval, ratio_text)})"
    share = f"{one.better} of {one.machines} ({low:.0f}–{high:.0f} %)"
    only = f"{one.only_first}, {one.only_second}"
    return [ratio, share, p_text(one.p_holm), str(one.both), only, str(one.neither)]


def ratio_text(value: float) -> str:
    """Return the text of a ratio: 0 if only the first design is stable, ∞ if only the second."""
    if isnan(value):
        return MISSING
    return f"{value:.3g}" if isfinite(value) else "∞"


def p_text(p: float) -> str:
    """Return the text of a probability."""
    return "< 0.0001" if p < 1e-4 else f"{p:.2g}"


def failures(comparison: Comparison) -> Iterator[str]:
    """Yield a line for each motion in which designs are not stable on every machine."""
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
    """Return a head, and a row for each design, machine (0: the nominal one) and motion."""
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
    """Return each parameter of the machines, (1 + machines,), the nominal machine first."""
    first = next(iter(bout.results.values()))
    each = zip(first.motion.axes, first.machines.actual, strict=True)
    several = len(first.machines.actual) > 1
    return {
        f"{axis.name}_{key}" if several else key: column
        for axis, record in each
        for key, column in record._asdict().items()
    }
