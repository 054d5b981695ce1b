"""What the page shows of a hierarchical design and of the search for it."""

import numpy as np

from hfc_design.controllers.hierarchical import pictures as diagrams
from hfc_design.controllers.hierarchical import tree as hierarchy
from hfc_design.files.controller import HierarchicalSettings
from hfc_design.files.design import Design
from hfc_design.files.scenario import Scenario
from hfc_design.pictures.section import Drawing, Listing, Section, score
from hfc_design.search.loop import Archive
from plants import PLANTS

#: This many structures are listed.
BEST = 10


def sections(design: Design) -> list[Section]:
    """The gains, the tree, the rule tables."""
    tree = Drawing(
        diagrams.tree(design),
        "The hierarchy drawn as a tree",
        "The hierarchy. Each unit reads a column input (left) and a row input (right); each input "
        "is multiplied by its scale and limited to [\u22121, 1].",
    )
    units = diagrams.hierarchical(design).units
    tables = [
        Drawing(
            figure,
            f"Heat map of the rule table of unit {unit.id}",
            f"Rule table of unit {unit.id}{', the root' if unit is units[-1] else ''}: the "
            "consequent for each pair of terms.",
        )
        for figure, unit in zip(diagrams.rule_tables(design), units, strict=True)
    ]
    return [Section("The controller", "", _parameters(design), [tree, *tables])]


def _parameters(design: Design) -> Listing:
    """Name, value and unit of the PD gains and of the hierarchy's scales."""
    controller = diagrams.hierarchical(design)
    units = PLANTS[design.plant.name].units
    command, error = units["command"], units["error"]
    rows = [
        ("proportional gain", controller.pd.kp, f"{command}/{error}"),
        ("derivative gain", controller.pd.kd, f"{command} s/{error}"),
    ]
    for item in controller.inputs:
        unit = f"per {diagrams.input_unit(design, item.name)}"
        rows.append((f"scale of {diagrams.readable(item.name)}", item.scale, unit))
    rows.append(("scale of the output", controller.output_scale, command))
    if adaptation := controller.adaptation:
        rows.append(("adaptation of the root: step", adaptation.k_c, "a sample"))
        rows.append(("adaptation of the root: largest move", adaptation.largest_move, ""))
    return Listing(
        "Gains of the PD part, scales of the inputs of the hierarchy and of its output.",
        ["parameter", "value", "unit"],
        [[name, f"{value:.6g}", unit] for name, value, unit in rows],
    )


def structures(archive: Archive, scenario: Scenario) -> Listing:
    """The best structures of the search and their scores."""
    assert isinstance(scenario.controller, HierarchicalSettings)
    names = [diagrams.readable(item.name) for item in scenario.controller.inputs]
    trees = hierarchy.trees(len(names))
    best = (-archive.score).argsort(kind="stable")[:BEST]
    order = best[np.isfinite(archive.score[best])]
    return Listing(
        "The best structures, each with the best that the search "
        f"(in {scenario.run.precision}) found for it; the controller above is the best of them in "
        "float64. A unit is written (column input, row input).",
        ["structure", scenario.judge().title],
        [
            [_notation(trees[archive.population.tree[k]], names), score(archive.score[k])]
            for k in order
        ],
    )


def _notation(tree: hierarchy.Tree, names: list[str]) -> str:
    """A tree as nested pairs (column input, row input)."""
    values = list(names)
    for unit in tree:
        values.append(f"({values[unit.column]}, {values[unit.row]})")
    return values[-1]
