"""Terms of fuzzy inputs drawn as degrees of membership, with one panel for each input."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.textpath import TextPath

from hfc_design.core.numbers import Floats
from hfc_design.plotting.figure import OTHER, OWN, WIDTH, framed

#: Margins beside a panel, and height of a single panel and of one of several [in].
LEFT, RIGHT, ALONE, SHARED = 0.9, 0.15, 1.55, 1.25
#: Names: size of the letters, distance of the rows, free space between two names and to the edge of
#: the figure [pt].
SIZE, ROW, FREE = 9.0, 11.0, 4.0
#: Factor by which a panel in the column of a paper shrinks more than its letters.
TIGHTER = 1.31
#: Highest degree that an axis shows.
TOP = 1.08
POINTS_PER_INCH = 72.0

Curve = tuple[Floats, Floats]  # values, degrees


class Panel(NamedTuple):
    """The terms of one input."""

    label: str  # the input and its unit
    ends: tuple[float, float]  # of the axis
    curves: Mapping[str, Curve]  # by the names of the terms, from the lowest to the highest
    before: Sequence[Curve] = ()  # drawn in grey below


class Place(NamedTuple):
    """Place of the name of a term."""

    top: float  # where the term is highest
    shift: float  # of the name from ``top``, so that the figure does not cut the name off [pt]
    row: int  # 0 is the lowest


def terms(panels: Sequence[Panel], title: str) -> Figure:
    """Draw degrees of membership, with names above the terms, in rows so that none overlap."""
    places = [_places(panel) for panel in panels]
    rows = 1 + max(place.row for row in places for place in row)
    band = (3.0 + ROW * rows) / POINTS_PER_INCH
    height, gap = (ALONE if len(panels) == 1 else SHARED), 0.6 + band
    whole = 0.4 + band + len(panels) * height + (len(panels) - 1) * gap + 0.5
    figure = framed(whole, top=0.4 + band, left=LEFT, right=RIGHT)
    each = figure.subplots(len(panels), 1, squeeze=False, gridspec_kw={"hspace": gap / height})
    for axes, panel, panel_places in zip(each[:, 0], panels, places, strict=True):
        _draw(axes, panel, panel_places)
    middle = 0.5 * (LEFT + WIDTH - RIGHT) / WIDTH
    figure.suptitle(title, x=middle, y=1.0 - 0.1 / whole, va="top", fontsize=11)
    return figure


def _draw(axes: Axes, panel: Panel, places: Sequence[Place]) -> None:
    for values, degrees in panel.before:
        axes.plot(values, degrees, color="0.65", lw=1.0, ls="--")
    named = zip(panel.curves.items(), places, strict=True)
    for k, ((name, (values, degrees)), place) in enumerate(named):
        color = (OWN, OTHER)[k % 2]
        axes.plot(values, degrees, color=color, lw=1.4)
        axes.annotate(
            name,
            (place.top, TOP),
            xytext=(place.shift, 3.0 + ROW * place.row),
            textcoords="offset points",
            ha="center",
            fontsize=SIZE,
            color=color,
            parse_math=False,
        )
    axes.set(xlim=panel.ends, ylim=(0.0, TOP), yticks=(0.0, 0.5, 1.0))
    axes.set(xlabel=panel.label, ylabel="degree [1]", axisbelow=True)
    axes.grid(color="0.93")


def _places(panel: Panel) -> list[Place]:
    """Place each name in the lowest row where it overlaps no previous one, on page or paper."""
    (low, high), wide = panel.ends, POINTS_PER_INCH * (WIDTH - LEFT - RIGHT)
    places: list[Place] = []
    filled: list[float] = []  # where the last name of each row ends
    for name, curve in panel.curves.items():
        values, degrees = curve
        highest = values[degrees >= degrees.max() - 1e-9]  # the name is above the middle
        top = 0.5 * float(highest[0] + highest[-1])
        half = 0.5 * TextPath((0.0, 0.0), name, size=SIZE).get_extents().width
        centre = (top - low) / (high - low) * wide
        left = centre / TIGHTER + POINTS_PER_INCH * LEFT - FREE
        right = (wide - centre) / TIGHTER + POINTS_PER_INCH * RIGHT - FREE
        shift = max(half - left, 0.0) - max(half - right, 0.0)
        begin = centre + min(shift - half, TIGHTER * (shift - half)) - FREE
        end = centre + max(shift + half, TIGHTER * (shift + half))
        row = next((k for k, edge in enumerate(filled) if edge <= begin), len(filled))
        filled[row : row + 1] = [end]
        places.append(Place(top, shift, row))
    return places
