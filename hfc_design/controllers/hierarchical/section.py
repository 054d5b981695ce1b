"""What the page shows of a hierarchical design."""

from hfc_design.controllers.hierarchical import pictures
from hfc_design.controllers.hierarchical.record import HierarchicalDesign
from hfc_design.controllers.kind import Shown
from hfc_design.pictures.section import Drawing, Listing, Section


def sections(record: HierarchicalDesign, shown: Shown) -> list[Section]:
    """The gains, the tree, the rule tables."""
    tree = Drawing(
        pictures.tree(record, shown.machine.drives[0]),
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
        for figure, unit in zip(pictures.rule_tables(record), units, strict=True)
    ]
    return [Section("The controller", "", _parameters(record, shown.units), [tree, *tables])]


def _parameters(controller: HierarchicalDesign, units: dict[str, str]) -> Listing:
    """Name, value and unit of the PD gains and of the hierarchy's scales."""
    command, error = units["command"], units["error"]
    rows = [
        ("proportional gain", controller.pd.kp, f"{command}/{error}"),
        ("derivative gain", controller.pd.kd, f"{command} s/{error}"),
    ]
    for item in controller.inputs:
        unit = f"per {pictures.input_unit(units, item.name)}"
        rows.append((f"scale of {pictures.readable(item.name)}", item.scale, unit))
    rows.append(("scale of the output", controller.output_scale, command))
    if adaptation := controller.adaptation:
        rows.append(("adaptation of the root: step", adaptation.k_c, "a sample"))
        rows.append(("adaptation of the root: largest move", adaptation.largest_move, ""))
    return Listing(
        "Gains of the PD part, scales of the inputs of the hierarchy and of its output.",
        ["parameter", "value", "unit"],
        [[name, f"{value:.6g}", unit] for name, value, unit in rows],
    )
