"""Pictures of a hierarchy: surface and table of each unit, the common terms, the tree."""

from collections.abc import Callable
from functools import partial

import numpy as np
from matplotlib.figure import Figure

from hfc_design.controllers import surfaces
from hfc_design.controllers.hierarchical.drawn_tree import drawn_tree, input_unit, readable
from hfc_design.controllers.hierarchical.law import averaged, memberships
from hfc_design.controllers.hierarchical.record import HierarchicalDesign, layout_of
from hfc_design.controllers.hierarchical.rules import units as rule_units
from hfc_design.controllers.surfaces import Side, Surface
from hfc_design.core.numbers import ARRAYS, Floats
from hfc_design.plotting import units
from hfc_design.plotting.heat_map import heat_map
from hfc_design.plotting.numbers import readable as in_unit
from hfc_design.plotting.section import Drawn
from hfc_design.plotting.terms import Panel
from hfc_design.plotting.terms import terms as drawn_terms
from plants import Drive

#: Largest value at which terms are drawn; inputs end at 1, but outputs of units may exceed it.
BEYOND = 1.25


def pictures(record: HierarchicalDesign, drive: Drive) -> dict[str, dict[str, Drawn]]:
    """Return functions that draw the pictures, by kind of picture and by name of the unit."""
    names = [f"unit-{unit.id}" for unit in record.units]
    made: dict[str, Callable[[], Surface]] = {
        name: partial(surface, record, drive, k) for k, name in enumerate(names)
    }
    tables: dict[str, Drawn] = {name: partial(table, record, k) for k, name in enumerate(names)}
    return {
        **surfaces.pictures(made),
        "terms": {"all units": partial(terms, record)},
        "tables": tables,
        "tree": {"": lambda: drawn_tree(record, drive)},
    }


def surface(record: HierarchicalDesign, drive: Drive, k: int) -> Surface:
    """Return the surface of ``record.units[k]`` over the ranges of its two inputs."""
    unit, root = record.units[k], k == len(record.units) - 1
    unit_terms, rules = layout_of(record).terms, rule_units(record)[k]

    def law(column: Floats, row: Floats) -> Floats:
        degrees = (memberships(ARRAYS, unit_terms, values) for values in (column, row))
        output: Floats = averaged(ARRAYS, rules.table, *degrees)
        return output

    column, row = (_side(record, drive, name) for name in (unit.column_input, unit.row_input))
    commands = root and record.scheduled is None  # else the root multiplies a law
    worth = (record.output_scale, drive.units["command"]) if commands else None
    title = f"unit {unit.id}" + ", the root" * root
    return Surface(title, rules, column, row, "output [1]", law, worth)


def table(record: HierarchicalDesign, k: int) -> Figure:
    """Draw the rule table of ``record.units[k]`` as a heat map."""
    unit, labels = record.units[k], [term.label for term in record.terms]
    row, column = f"row: {readable(unit.row_input)}", f"column: {readable(unit.column_input)}"
    values, title = np.array(record.tables()[k]), f"unit {unit.id}"
    return heat_map(values, (labels, labels), row, column, title, "consequent [1]")


def _side(record: HierarchicalDesign, drive: Drive, source: str) -> Side:
    """Return the name, the unit of measurement and the range of what a fuzzy unit reads."""
    scales = {item.name: item.scale for item in record.inputs}
    if source in scales:
        largest = 1.0 / scales[source]
        factor, unit = in_unit(input_unit(drive.units, source), largest)
        end = factor * largest
        return Side(readable(source), unit, (-end, end), scales[source] / factor)
    place = [f"unit-{unit.id}" for unit in record.units].index(source)
    said = np.array(record.tables()[place])  # its output is an average of these
    ends = min(0.0, float(said.min())), max(0.0, float(said.max())) or 1.0
    return Side(readable(source), "1", ends)


def terms(record: HierarchicalDesign) -> Figure:
    """Draw the terms, which all inputs of all units have in common."""
    unit_terms = layout_of(record).terms
    grid = np.linspace(-BEYOND, BEYOND, 4 * units.POINTS + 1)
    values = np.union1d(grid, [term.centre for term in unit_terms])  # where they are highest
    degrees = memberships(ARRAYS, unit_terms, values)
    pairs = zip(unit_terms, degrees, strict=True)
    curves = {term.label: (values, membership) for term, membership in pairs}
    panel = Panel("input of a unit, scaled [1]", (-BEYOND, BEYOND), curves)
    return drawn_terms([panel], "terms of every unit")
