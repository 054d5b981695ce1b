"""What the page shows of a hierarchy: its gains, the tree, its rule tables as heat maps."""

import textwrap

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hfc_design.controllers.controller import units_of
from hfc_design.controllers.hierarchical.law import PREVIOUS
from hfc_design.controllers.hierarchical.loop import open_loop
from hfc_design.controllers.hierarchical.record import HierarchicalDesign
from hfc_design.controllers.hierarchical.schedule_section import schedule
from hfc_design.controllers.kind import Shown
from hfc_design.controllers.linear import section as linear
from hfc_design.pictures.displayed import Displayed
from hfc_design.pictures.figure import OTHER, OWN, WIDTH, Drawing, Listing, Section, heat_map
from plants import Drive


def sections(record: HierarchicalDesign, shown: Shown) -> list[Section]:
    """The gains, the tree, the rule tables."""
    tree = Drawing(
        drawn_tree(record, shown.machine.drives[0]),
        "The hierarchy drawn as a tree",
        "The hierarchy. Each unit reads a column input (left) and a row input (right); each input "
        "is multiplied by its scale and limited to [\u22121, 1].",
    )
    units = record.units
    tables = [
        Drawing(
            figure,
            f"Heat map of the rule table of unit {unit.id}",
            f"Rule table of unit {unit.id}{', the root' if unit is units[-1] else ''}: the "
            "consequent for each pair of terms.",
        )
        for figure, unit in zip(rule_tables(record), units, strict=True)
    ]
    drawn = [tree, *tables]
    if record.scheduled is not None:
        names = [item.name for item in record.inputs]
        told = {name: readable(name) for name in names}
        drawn.insert(1, schedule(record, told, {x: input_unit(shown.units, x) for x in names}))
    found = [Section("The controller", "", _parameters(record, shown.units), drawn)]
    if record.linear is not None:
        found.append(linear.loop_section(record, shown, open_loop))
    return found


def _parameters(controller: HierarchicalDesign, units: dict[str, str]) -> Listing:
    """Name, value and unit of the PD gains and of the hierarchy's scales."""
    command, error = units["command"], units["error"]
    rows = [
        ("proportional gain", controller.pd.kp, f"{command}/{error}"),
        ("derivative gain", controller.pd.kd, f"{command} s/{error}"),
    ]
    if part := controller.linear_part:
        rows = linear.rows(part, units)
    if part := controller.scheduled_part:
        rows += [(f"scheduled: {name}", x, unit) for name, x, unit in linear.rows(part, units)]
    for item in controller.inputs:
        unit = f"per {input_unit(units, item.name)}"
        rows.append((f"scale of {readable(item.name)}", item.scale, unit))
    output_unit = "1" if controller.scheduled else command
    rows.append(("scale of the output", controller.output_scale, output_unit))
    if adaptation := controller.adaptation:
        rows.append(("adaptation of the root: step", adaptation.k_c, "a sample"))
        rows.append(("adaptation of the root: largest move", adaptation.largest_move, ""))
    return Listing(
        f"Gains of the {_part(controller)} part"
        + ", of the scheduled law, which the hierarchy's output multiplies" * _schedules(controller)
        + ", scales of the inputs of the hierarchy and of its output.",
        ["parameter", "value", "unit"],
        [[name, f"{value:.6g}", unit] for name, value, unit in rows],
    )


def _part(controller: HierarchicalDesign) -> str:
    return "PD" if controller.linear is None else "linear"


def _schedules(controller: HierarchicalDesign) -> bool:
    return controller.scheduled is not None


def drawn_tree(controller: HierarchicalDesign, drive: Drive) -> Figure:
    """The hierarchy with its root on top, for a ``drive``.

    Each unit stands above what it reads: the column input on the left, the row input on the
    right.
    """
    units = {f"unit-{unit.id}": unit for unit in controller.units}
    scales = {item.name: item.scale for item in controller.inputs}
    figure = Displayed()
    axes = figure.add_axes((0, 0, 1, 1))
    leaves: list[str] = []
    deepest = 0

    def place(name: str, depth: int) -> tuple[float, float]:
        """Draw ``name`` and what is below it; returns where it stands."""
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
    unit = "× scheduled law" if _schedules(controller) else drive.units["command"]
    axes.text(x + 0.06, y + 0.42, f"× {controller.output_scale:g} {unit}", fontsize=10)
    _box(axes, x, y + 1, f"{drive.command_name} = {_part(controller)} part + hierarchy")
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


def rule_tables(controller: HierarchicalDesign) -> list[Figure]:
    """One heat map a unit, in evaluation order."""
    labels = [term.label for term in controller.terms]
    found = []
    for unit, consequents in zip(controller.units, controller.tables(), strict=True):
        row, column = f"row: {readable(unit.row_input)}", f"column: {readable(unit.column_input)}"
        table = np.array(consequents)
        found.append(
            heat_map(table, (labels, labels), row, column, f"unit {unit.id}", "consequent [1]")
        )
    return found


def readable(source: str) -> str:
    """The source of a unit's input as words."""
    if source.startswith("unit-"):
        return f"output of {source.replace('-', ' ')}"
    return source.replace("_", " ")


def input_unit(units: dict[str, str], name: str) -> str:
    """Unit of an input of the hierarchy before it is scaled."""
    return units_of(units).get(name.removeprefix(PREVIOUS), "1")
