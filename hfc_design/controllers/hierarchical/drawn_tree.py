"""Drawing of a hierarchy as a tree, and the names used in pictures of hierarchies."""

import textwrap

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hfc_design.controllers.controller import units_of
from hfc_design.controllers.hierarchical.law import PREVIOUS
from hfc_design.controllers.hierarchical.record import HierarchicalDesign
from hfc_design.plotting.figure import OTHER, OWN, WIDTH
from hfc_design.plotting.files import Displayed
from plants import Drive


def drawn_tree(controller: HierarchicalDesign, drive: Drive) -> Figure:
    """Draw the tree of a hierarchy, the root on top, with the units of measurement of ``drive``.

    Each fuzzy unit is above its inputs: column input on the left, row input on the right.
    """
    units = {f"unit-{unit.id}": unit for unit in controller.units}
    scales = {item.name: item.scale for item in controller.inputs}
    figure = Displayed()
    axes = figure.add_axes((0, 0, 1, 1))
    leaves: list[str] = []
    deepest = 0

    def place(name: str, depth: int) -> tuple[float, float]:
        """Draw the input or unit ``name`` and all below it; return where (x, y) it is."""
        nonlocal deepest
        deepest = max(deepest, depth)
        if name not in units:
            leaves.append(name)
            return _leaf(axes, drive, name, scales[name], len(leaves) - 0.5, depth)
        unit = units[name]
        below = [place(source, depth + 1) for source in (unit.column_input, unit.row_input)]
        x = sum(place[0] for place in below) / 2
        _branch(axes, (x, -depth), below[0], "column", OWN)
        _branch(axes, (x, -depth), below[1], "row", OTHER)
        _box(axes, x, -depth, name.replace("-", " "))
        return x, -depth

    x, y = place(f"unit-{controller.units[-1].id}", 0)
    arrow = {"arrowstyle": "-|>", "color": "0.3"}
    axes.annotate("", (x, y + 0.8), (x, y), arrowprops=arrow, zorder=0)
    unit = "× scheduled law" if controller.scheduled is not None else drive.units["command"]
    axes.text(x + 0.06, y + 0.42, f"× {controller.output_scale:g} {unit}", fontsize=10)
    _box(axes, x, y + 1, f"{drive.command_name} = {part_called(controller)} part + hierarchy")
    axes.set(xlim=(0, len(leaves)), ylim=(-deepest - 1.0, 1.4))
    axes.set_axis_off()
    figure.set_size_inches(WIDTH, 0.75 * (deepest + 2.4))
    return figure


def _box(axes: Axes, x: float, y: float, text: str) -> None:
    frame = {"boxstyle": "round,pad=0.4", "facecolor": "#E8F1F8", "edgecolor": "0.3"}
    axes.text(x, y, text, ha="center", va="center", fontsize=10, bbox=frame)


def _leaf(
    axes: Axes, drive: Drive, name: str, scale: float, x: float, depth: int
) -> tuple[float, float]:
    words = textwrap.wrap(readable(name), 11)
    text = "\n".join([*words, f"× {scale:.4g}", f"per {input_unit(drive.units, name)}"])
    axes.text(x, 0.12 - depth, text, ha="center", va="top", fontsize=9, linespacing=1.15)
    return x, 0.15 - depth


def _branch(
    axes: Axes, start: tuple[float, float], end: tuple[float, float], text: str, color: str
) -> None:
    axes.plot(*zip(start, end, strict=True), color=color, lw=1.3, zorder=0)
    x, y = (0.42 * a + 0.58 * b for a, b in zip(start, end, strict=True))
    frame = {"facecolor": "white", "edgecolor": "none", "pad": 1}
    axes.text(x, y, text, ha="center", va="center", fontsize=9, color=color, bbox=frame)


def part_called(controller: HierarchicalDesign) -> str:
    """Return the name of the linear part to which the hierarchy is added."""
    return "PD" if controller.linear is None else "linear"


def readable(source: str) -> str:
    """Return the source of a unit's input in words."""
    if source.startswith("unit-"):
        return f"output of {source.replace('-', ' ')}"
    return source.replace("_", " ")


def input_unit(units: dict[str, str], name: str) -> str:
    """Return the unit of measurement of input ``name`` before it is scaled; "1" if unknown."""
    return units_of(units).get(name.removeprefix(PREVIOUS), "1")
