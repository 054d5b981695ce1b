"""The surface of a two-input unit: its pictures, and the numbers that show which rules fire on it.

The numbers are part of a report, where a script moves a cursor over the picture.
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

    name: str  # for people
    unit: str
    ends: tuple[float, float]  # of the picture, in that unit
    enters: float = 1.0  # what enters the unit for 1 of that

    @property
    def label(self) -> str:
        """Name and unit."""
        return f"{self.name} [{self.unit}]"

    @property
    def points(self) -> Floats:
        """(points,) values at which the picture is computed."""
        return np.linspace(*self.ends, units.POINTS)


class Surface(NamedTuple):
    """Output of a unit over its two inputs."""

    title: str  # stands above
    unit: RuleUnit  # its terms are of what enters
    column: Side
    row: Side
    said: str  # name of the output and its unit
    #: (column (columns,), row (rows, 1)) as they enter -> output (rows, columns), by the law.
    law: Callable[[Floats, Floats], Floats]
    #: What of the command an output of 1 is, and its unit; None: nothing that can be said so.
    worth: tuple[float, str] | None = None

    def values(self) -> Floats:
        """(rows, columns) output at the points of both sides."""
        column, row = self.column, self.row
        return self.law(column.enters * column.points, row.enters * row.points[:, None])


def flat(surface: Surface) -> Figure:
    """The surface in colours."""
    return _figure(units.surface, surface)


def solid(surface: Surface) -> Figure:
    """The surface in three dimensions."""
    return _figure(units.solid, surface)


def _figure(draw: Callable[..., Figure], surface: Surface) -> Figure:
    column, row = surface.column, surface.row
    labels = column.label, row.label
    values = surface.values()
    return draw(column.points, row.points, values, labels, surface.title, surface.said)


def pictures(surfaces: Mapping[str, Callable[[], Surface]]) -> dict[str, dict[str, Drawn]]:
    """Pictures of surfaces for ``Kind.pictures``, by the names of the units."""
    return {
        what: {name: partial(_of, draw, made) for name, made in surfaces.items()}
        for what, draw in (("surface", flat), ("surface-3d", solid))
    }


def _of(draw: Callable[[Surface], Figure], made: Callable[[], Surface]) -> Figure:
    return draw(made())


def drawing(surface: Surface, caption: str) -> Drawing:
    """Picture with a cursor on it, for a report."""
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
    """An edge that is infinite is null."""
    term_data = [
        {key: x if isinstance(x, str) or isfinite(x) else None for key, x in fields.items()}
        for fields in (term._asdict() for term in terms)
    ]
    return {**side._asdict(), "terms": term_data}
