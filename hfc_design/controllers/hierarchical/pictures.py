"""A hierarchy drawn for ``hfc plot``: the surface of each unit, its terms, its table, the tree."""

from functools import partial

import numpy as np
from matplotlib.figure import Figure

from hfc_design.controllers.hierarchical.law import averaged, memberships
from hfc_design.controllers.hierarchical.record import HierarchicalDesign, layout_of
from hfc_design.controllers.hierarchical.section import (
    drawn_tree,
    input_unit,
    readable,
    rule_tables,
)
from hfc_design.core.numbers import ARRAYS, Floats
from hfc_design.pictures import units
from hfc_design.pictures.numbers import readable as in_unit
from hfc_design.pictures.section import Drawn
from plants import Drive

#: The terms are drawn up to here; inputs end at 1, outputs of units go on.
BEYOND = 1.25


def pictures(record: HierarchicalDesign, drive: Drive) -> dict[str, dict[str, Drawn]]:
    """Kind of picture -> name of a unit -> what draws it."""
    names = [f"unit-{unit.id}" for unit in record.units]
    surfaces: dict[str, Drawn] = {
        name: partial(surface, record, drive, k) for k, name in enumerate(names)
    }
    tables: dict[str, Drawn] = {name: partial(table, record, k) for k, name in enumerate(names)}
    return {
        "surface": surfaces,
        "terms": {"all units": partial(terms, record)},
        "tables": tables,
        "tree": {"": lambda: drawn_tree(record, drive)},
    }


def surface(record: HierarchicalDesign, drive: Drive, k: int) -> Figure:
    """What unit ``k`` of the list makes of all that its two inputs can be."""
    unit, own = record.units[k], layout_of(record).terms
    (x, column, x_label), (y, row, y_label) = (
        _range(record, drive, source) for source in (unit.column_input, unit.row_input)
    )
    in_column, in_row = memberships(ARRAYS, own, column), memberships(ARRAYS, own, row[:, None])
    values = averaged(ARRAYS, record.tables()[k], in_column, in_row)
    title = f"unit {unit.id}" + ", the root" * (unit is record.units[-1])
    return units.surface(x, y, values, (x_label, y_label), title, "output [1]")


def table(record: HierarchicalDesign, k: int) -> Figure:
    """The rule table of unit ``k`` of the list."""
    return rule_tables(record)[k]


def _range(record: HierarchicalDesign, drive: Drive, source: str) -> tuple[Floats, Floats, str]:
    """All that a source can be, as its axis shows it and as it enters a unit; the axis' label."""
    scales = {item.name: item.scale for item in record.inputs}
    if source in scales:
        enters = np.linspace(-1.0, 1.0, units.POINTS)
        factor, unit = in_unit(input_unit(drive.units, source), 1.0 / scales[source])
        return factor / scales[source] * enters, enters, f"{readable(source)} [{unit}]"
    place = [f"unit-{unit.id}" for unit in record.units].index(source)
    said = np.array(record.tables()[place])  # an average of these
    enters = np.linspace(min(0.0, said.min()), max(0.0, said.max()) or 1.0, units.POINTS)
    return enters, enters, f"{readable(source)} [1]"


def terms(record: HierarchicalDesign) -> Figure:
    """The terms of every input of every unit."""
    values, own = np.linspace(-BEYOND, BEYOND, 4 * units.POINTS + 1), layout_of(record).terms
    degrees = memberships(ARRAYS, own, values)
    named = {term.label: degree for term, degree in zip(own, degrees, strict=True)}
    return units.terms(values, named, "input of a unit, scaled [1]", "terms of every unit")
