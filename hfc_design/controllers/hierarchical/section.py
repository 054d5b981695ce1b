"""Report sections of a hierarchy: gains, tree, and table and surface of each unit."""

from hfc_design.controllers import surfaces
from hfc_design.controllers.hierarchical.drawn_tree import (
    drawn_tree,
    input_unit,
    part_called,
    readable,
)
from hfc_design.controllers.hierarchical.pictures import surface, table
from hfc_design.controllers.hierarchical.record import HierarchicalDesign
from hfc_design.controllers.hierarchical.schedule_section import schedule
from hfc_design.controllers.kind import ReportContext
from hfc_design.controllers.linear import section as linear
from hfc_design.core.tables import Table
from hfc_design.plotting.section import Drawing, Section

UNITS = (
    "The output of a unit is the average of the consequents of its rules, weighted by "
    "their firing strengths; the root comes last."
)


def sections(record: HierarchicalDesign, shown: ReportContext) -> list[Section]:
    """Return two sections: the gains with the tree, and the drawings of the units."""
    tree = Drawing(
        drawn_tree(record, shown.machine.drives[0]),
        "The hierarchy drawn as a tree",
        "The hierarchy. Each unit reads a column input (left) and a row input (right); each input "
        "is multiplied by its scale and limited to [\u22121, 1].",
    )
    units = [drawing for k in range(len(record.units)) for drawing in _unit(record, shown, k)]
    drawn = [tree]
    if record.scheduled is not None:
        names = [item.name for item in record.inputs]
        labels = {name: readable(name) for name in names}
        drawn.append(schedule(record, labels, {x: input_unit(shown.units, x) for x in names}))
    return [
        Section("The controller", "", _parameters(record, shown.units), drawn),
        Section("Its units", UNITS, None, units),
    ]


def _unit(record: HierarchicalDesign, shown: ReportContext, k: int) -> list[Drawing]:
    """Return the drawings of the table and of the surface of ``record.units[k]``."""
    unit, root = record.units[k], k == len(record.units) - 1
    name = f"unit {unit.id}{', the root' if root else ''}"
    begins = " before it adapts" if root and record.adaptation else ""
    return [
        Drawing(
            table(record, k),
            f"Heat map of the rule table of unit {unit.id}",
            f"Rule table of {name}{begins}: the consequent for each pair of terms.",
        ),
        surfaces.drawing(
            surface(record, shown.machine.drives[0], k),
            f"Surface of {name}{begins}: its output over the ranges of its two inputs.",
        ),
    ]


def _parameters(controller: HierarchicalDesign, units: dict[str, str]) -> Table:
    """Return the table (name, value, unit) of all gains, of the scales and of the adaptation."""
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
    return Table(
        f"Gains of the {part_called(controller)} part"
        + ", of the scheduled law, which the hierarchy's output multiplies"
        * (controller.scheduled is not None)
        + ", scales of the inputs of the hierarchy and of its output.",
        ["parameter", "value", "unit"],
        [[name, f"{value:.6g}", unit] for name, value, unit in rows],
    )
