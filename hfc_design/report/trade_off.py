"""The front of a run as a picture and as a table."""

from itertools import combinations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter

from hfc_design.core.tables import Table
from hfc_design.plotting.figure import OTHER, OWN, above, framed, gridded
from hfc_design.plotting.numbers import readable, score
from hfc_design.plotting.section import Drawing, Section
from hfc_design.runs.front import Front, marks

#: Largest number of rows of a front; ``front.csv`` has all.
SHOWN = 12
EMPTY = (
    "No design meets every constraint on every machine, so there is no front; the "
    "controller above is the one that violates the constraints least."
)


def section(front: Front) -> Section:
    """Return a section with the points of the front."""
    title = "Pareto front"
    if not len(front.merit):
        return Section(title, EMPTY, None, [])
    text = (
        f"{len(front.merit)} designs meet every constraint, and none is worse than "
        "another in every objective. The table shows some of them, front.csv all; hfc "
        "pick makes a design file of any point."
    )
    return Section(title, text, front_table(front), [_drawing(front)])


def front_table(front: Front, most: int = SHOWN) -> Table:
    """Return a table of up to ``most`` points: the ends, the marked ones, others between them."""
    units = [_unit(front, k) for k in range(len(front.objectives))]
    pairs = zip(front.objectives, units, strict=True)
    head = ["point", *(_label(one.name, unit) for one, (_, unit) in pairs), "merit", ""]
    size = len(front.merit)
    chosen = {front.knee, front.best}
    even = np.round(np.linspace(0, size - 1, min(most - len(chosen), size))).astype(int)
    rows = []
    for k in sorted(chosen.union(even.tolist())):
        costs = (f"{factor * x:.4g}" for (factor, _), x in zip(units, front.costs[k], strict=True))
        mark = marks(front)[k].replace("design", "design.json").replace(" ", ", ")
        rows.append([str(k + 1), *costs, score(front.merit[k]), mark])
    title = f"trade-off: {len(rows)} of the {size} points of front.csv"
    return Table("Points of the front.", head, rows, title=title)


def _unit(front: Front, k: int) -> tuple[float, str]:
    return readable(front.objectives[k].unit, float(np.median(front.costs[:, k])))


def _label(name: str, unit: str) -> str:
    return name if unit == "1" else f"{name} [{unit}]"


def _drawing(front: Front) -> Drawing:
    """Draw the front, with a panel for every pair of objectives."""
    pairs = [*combinations(range(len(front.objectives)), 2)]
    figure = framed(3.3 * len(pairs) + 0.35, top=0.35)
    panels = figure.subplots(len(pairs), 1, squeeze=False, gridspec_kw={"hspace": 0.3})[:, 0]
    for axes, (x, y) in zip(panels, pairs, strict=True):
        _panel(axes, front, x, y)
    above(figure, panels[0], columns=3)
    names = [one.name for one in front.objectives]
    meanings = "; ".join(f"{one.name}: {one.meaning}" for one in front.objectives)
    return Drawing(
        figure,
        f"Points of the front: {' against '.join(names)}",
        f"The front, lower is better everywhere: {meanings}. At the knee, a small gain in "
        "one objective costs much in another; design.json is the point with the best "
        "merit of the scenario. Numbers are those of the points.",
    )


def _panel(axes: Axes, front: Front, x: int, y: int) -> None:
    (to_x, unit_x), (to_y, unit_y) = _unit(front, x), _unit(front, y)
    across, up = to_x * front.costs[:, x], to_y * front.costs[:, y]
    axes.plot(across, up, "o", color=OWN, ms=4, label="front")
    knee, best = front.knee, front.best
    axes.plot(across[knee], up[knee], "D", color=OTHER, ms=9, mfc="none", mew=1.6, label="knee")
    axes.plot(across[best], up[best], "s", color="black", ms=13, mfc="none", label="design.json")
    for k in sorted({0, knee, best, len(up) - 1}):
        axes.annotate(
            str(k + 1), (across[k], up[k]), (6, 4), textcoords="offset points", fontsize=9
        )
    for values, scale, marked in (
        (across, axes.set_xscale, axes.xaxis),
        (up, axes.set_yscale, axes.yaxis),
    ):
        if values.min() > 0.0 and values.max() > 20.0 * values.min():
            scale("log")
            marked.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.margins(0.1)
    names = [front.objectives[k].name for k in (x, y)]
    gridded(axes, _label(names[0], unit_x), _label(names[1], unit_y))
