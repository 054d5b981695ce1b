"""Pictures of adaptive fuzzy sliding control: rules, surface, terms, what they learn."""

import numpy as np
from matplotlib.figure import Figure

from hfc_design.controllers import surfaces
from hfc_design.controllers.fuzzy_sliding.export import units as rule_units
from hfc_design.controllers.fuzzy_sliding.law import degrees
from hfc_design.controllers.fuzzy_sliding.record import LABELS, SlidingDesign
from hfc_design.controllers.surfaces import Side, Surface
from hfc_design.core.numbers import ARRAYS, Floats
from hfc_design.core.records import ZR
from hfc_design.pictures.figure import (
    OTHER,
    OWN,
    STRIP,
    colour_strip,
    drawable,
    finish,
    framed,
    gridded,
)
from hfc_design.pictures.heat_map import heat_map
from hfc_design.pictures.section import Drawn
from hfc_design.pictures.terms import Panel, terms
from plants import Drive

#: Terms and surfaces are drawn up to this share of the outermost centre.
BEYOND = 1.25
#: Samples of a picture over time, at most: as many columns as can be seen.
COLUMNS = 400


def rules(values: Floats, title: str, meaning: str, moved: Floats | None = None) -> Figure:
    """The rule table (7, 7); with what each has ``moved`` by as colours."""
    names = "row: error", "column: rate of the error"
    return heat_map(values, (LABELS, LABELS), *names, title, meaning, moved)


def surface(record: SlidingDesign, drive_units: dict[str, str], title: str) -> Surface:
    """What the rules command, without the switching part."""
    gains, (unit,) = record.gains(), rule_units(record)

    def law(rate: Floats, error: Floats) -> Floats:
        in_error = np.array(degrees(ARRAYS, gains.error_terms * error[:, 0]))
        in_rate = np.array(degrees(ARRAYS, gains.rate_terms * rate))
        found: Floats = in_error.T @ np.array(unit.table) @ in_rate  # degrees add up to 1
        return found

    rate, error = _side(record, drive_units, "error_rate"), _side(record, drive_units, "error")
    return Surface(title, unit, rate, error, f"command [{drive_units['command']}]", law)


def _side(record: SlidingDesign, drive_units: dict[str, str], name: str) -> Side:
    reach = BEYOND * float(getattr(record, f"largest_{name}"))
    return Side(name.replace("_", " "), drive_units[name], (-reach, reach))


def pictures(record: SlidingDesign, drive: Drive) -> dict[str, dict[str, Drawn]]:
    """For ``hfc plot``: the rules without what they learn and without the switching part."""
    told, table = f"command [{drive.units['command']}]", np.array(record.table())
    return {
        **surfaces.pictures({"rules": lambda: surface(record, drive.units, "control surface")}),
        "terms": {"rules": lambda: _terms(record, drive.units)},
        "tables": {"rules": lambda: rules(table, "rule table", told)},
    }


def _terms(record: SlidingDesign, drive_units: dict[str, str]) -> Figure:
    """Of the error and of its rate: straight from centre to centre."""
    places = np.array([-BEYOND * ZR, *range(-ZR, ZR + 1), BEYOND * ZR])
    named = dict(zip(LABELS, np.array(degrees(ARRAYS, places)), strict=True))
    panels = []
    for name in ("error", "error_rate"):
        side = _side(record, drive_units, name)
        values = places / (BEYOND * ZR) * side.ends[1]
        curves = {label: (values, own) for label, own in named.items()}
        panels.append(Panel(side.label, side.ends, curves))
    return terms(panels, "terms")


def phase_plane(
    record: SlidingDesign, drive_units: dict[str, str], name: str, error: Floats, rate: Floats
) -> Figure:
    """Where the axis was, the surface and its boundary layer."""
    figure = framed(4.0, top=0.35)
    axes, surface = figure.subplots(), record.sliding
    error, rate = (drawable(values) for values in (error, rate))
    reach = 1.05 * max(float(np.abs(error).max()), 1e-12 * record.largest_error)
    ends = np.array([-reach, reach])
    line, layer = -surface.slope * ends, surface.boundary_layer
    axes.fill_between(ends, line - layer, line + layer, color="0.88")
    axes.plot(ends, line, color=OTHER, lw=1.0, label="s = 0")
    axes.plot(error, rate, color=OWN, lw=0.7)
    most = 1.1 * max(float(np.abs(rate).max()), layer)
    axes.set(xlim=(-reach, reach), ylim=(-most, most))
    axes.set_title(f"phase plane of {name}", fontsize=11)
    x = f"error e [{drive_units['error']}]"
    finish(axes, f"rate de/dt [{drive_units['error_rate']}]", x)
    return figure


def over_time(moves: Floats, every: float, unit: str, title: str) -> Figure:
    """The moves (steps, 7, 7) as a picture: a column a moment, a row a rule."""
    figure = framed(4.6, top=0.35, right=STRIP)
    axes, count = figure.subplots(), len(LABELS)
    steps = np.unique(np.linspace(0, len(moves) - 1, COLUMNS).astype(int))
    values = drawable(moves[steps]).reshape(len(steps), -1).T
    limit = float(np.abs(values).max()) or 1.0
    times = every * np.append(steps, len(moves))
    edges = np.arange(count * count + 1)
    mesh = axes.pcolormesh(times, edges, values, cmap="RdBu_r", vmin=-limit, vmax=limit)
    mesh.set_rasterized(True)
    for k in range(1, count):
        axes.axhline(count * k, color="0.6", lw=0.5)
    axes.set_yticks(count * (np.arange(count) + 0.5), LABELS)
    axes.tick_params(axis="y", length=0)
    axes.invert_yaxis()
    gridded(axes, "time [s]", "term of the error")
    axes.grid(visible=False)
    axes.set_title(title, fontsize=11)
    colour_strip(figure, axes, mesh, f"moved by {unit}").outline.set_visible(False)
    return figure
