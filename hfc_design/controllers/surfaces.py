"""Surface of a fuzzy unit with two inputs: pictures of it, and numbers for a cursor.

In a report the user moves a cursor over the picture; a script shows which rules fire there.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from math import isfinite
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

from hfc_design.controllers.rules import RuleUnit, Term
from hfc_design.core.numbers import Floats, Json
from hfc_design.plotting import units
from hfc_design.plotting.section import Drawing, Drawn


class Side(NamedTuple):
    """One input of a unit, as an axis of its surface."""

    name: str  # name of the input in texts
    unit: str  # physical unit of the axis
    ends: tuple[float, float]  # ends of the axis, in this physical unit
    enters: float = 1.0  # factor from values on the axis to values that the fuzzy unit reads

    @property
    def label(self) -> str:
        """Name and physical unit, as the label of the axis."""
        return f"{self.name} [{self.unit}]"

    @property
    def points(self) -> Floats:
        """(points,) values at which the picture is computed."""
        return np.linspace(*self.ends, units.POINTS)


class Surface(NamedTuple):
    """Output of a unit over its two inputs."""

    title: str  # title above the picture
    unit: RuleUnit  # its terms are in values that the unit reads, see ``Side.enters``
    column: Side
    row: Side
    said: str  # name of the output, with its physical unit in brackets
    #: (column (columns,), row (rows, 1)) as the unit reads them -> output (rows, columns).
    law: Callable[[Floats, Floats], Floats]
    #: Command for an output of 1, and the unit of the command; None: not known, or the same.
    worth: tuple[float, str] | None = None

    def values(self) -> Floats:
        """Return the output (rows, columns) at the points of both sides."""
        column, row = self.column, self.row
        return self.law(column.enters * column.points, row.enters * row.points[:, None])


def flat(surface: Surface) -> Figure:
    """Draw the surface in colours."""
    return _drawn(units.surface, lambda: surface)


def _drawn(draw: Callable[..., Figure], made: Callable[[], Surface]) -> Figure:
    surface = made()
    column, row = surface.column, surface.row
    labels = column.label, row.label
    values = surface.values()
    return draw(column.points, row.points, values, labels, surface.title, surface.said)


def pictures(surfaces: Mapping[str, Callable[[], Surface]]) -> dict[str, dict[str, Drawn]]:
    """Return the entries for ``ControllerRecord.pictures``: {picture: {name of a unit: Drawn}}."""
    return {
        what: {name: partial(_drawn, draw, made) for name, made in surfaces.items()}
        for what, draw in (("surface", units.surface), ("surface-3d", units.solid))
    }


def drawing(surface: Surface, caption: str) -> Drawing:
    """Return a picture for a report, with the numbers for a cursor."""
    figure, said = flat(surface), surface.said.partition(" [")[0]
    title = surface.title[0].upper() + surface.title[1:]
    place = figure.axes[0].get_position()
    return Drawing(
        figure,
        f"{title}: {said} over {surface.row.name} and {surface.column.name}",
        caption,
        {
            "box": [place.x0, 1.0 - place.y1, place.width, place.height],  # from the upper left
            "column": _side(surface.column, surface.unit.column_terms),
            "row": _side(surface.row, surface.unit.row_terms),
            "table": [[float(value) for value in row] for row in surface.unit.table],
            "labels": surface.unit.labels,
            "said": surface.said,
            "worth": surface.worth,
        },
    )


def _side(side: Side, terms: Sequence[Term]) -> Json:
    """Return a side and its terms as JSON; an infinite edge is None."""
    term_data = [
        {key: x if isinstance(x, str) or isfinite(x) else None for key, x in fields.items()}
        for fields in (term._asdict() for term in terms)
    ]
    return {**side._asdict(), "terms": term_data}
