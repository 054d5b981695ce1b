"""Pictures of adaptive fuzzy sliding control: rules, surface, terms, and learning."""

from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

from hfc_design.controllers import surfaces
from hfc_design.controllers.fuzzy_sliding.export import units as rule_units
from hfc_design.controllers.fuzzy_sliding.law import degrees
from hfc_design.controllers.fuzzy_sliding.record import LABELS, SlidingDesign
from hfc_design.controllers.kind import ReportContext, memories
from hfc_design.controllers.surfaces import Side, Surface
from hfc_design.core.numbers import ARRAYS, Floats
from hfc_design.core.records import ZR
from hfc_design.core.tables import Table
from hfc_design.plotting.figure import (
    OTHER,
    OWN,
    STRIP,
    colour_strip,
    drawable,
    finish,
    framed,
    gridded,
)
from hfc_design.plotting.heat_map import heat_map
from hfc_design.plotting.section import Drawing, Drawn, Section
from hfc_design.plotting.terms import Panel, terms
from plants import Drive

#: Terms and surfaces are drawn up to this multiple of the outermost centres.
BEYOND = 1.25
#: Largest number of columns in a picture over time; more could not be distinguished.
COLUMNS = 400


def rules(values: Floats, title: str, meaning: str, moved: Floats | None = None) -> Figure:
    """Draw a rule table (7, 7); colours show ``values``, or how far the rules have ``moved``."""
    names = "row: error", "column: rate of the error"
    return heat_map(values, (LABELS, LABELS), *names, title, meaning, moved)


def surface(record: SlidingDesign, drive_units: dict[str, str], title: str) -> Surface:
    """Return the surface of the rules alone, without switching part and linear gains."""
    gains, (unit,) = record.law_gains(), rule_units(record)

    def law(rate: Floats, error: Floats) -> Floats:
        in_error = np.array(degrees(ARRAYS, gains.error_terms * error[:, 0]))
        in_rate = np.array(degrees(ARRAYS, gains.rate_terms * rate))
        command: Floats = in_error.T @ np.array(unit.table) @ in_rate  # degrees add up to 1
        return command

    rate, error = _side(record, drive_units, "error_rate"), _side(record, drive_units, "error")
    return Surface(title, unit, rate, error, f"command [{drive_units['command']}]", law)


def _side(record: SlidingDesign, drive_units: dict[str, str], name: str) -> Side:
    span = BEYOND * float(getattr(record, f"largest_{name}"))
    return Side(name.replace("_", " "), drive_units[name], (-span, span))


def pictures(record: SlidingDesign, drive: Drive) -> dict[str, dict[str, Drawn]]:
    """Return pictures of the rules for ``hfc plot``, with the moves in the record but no others."""
    label, table = f"command [{drive.units['command']}]", np.array(record.table())
    return {
        **surfaces.pictures({"rules": lambda: surface(record, drive.units, "control surface")}),
        "terms": {"rules": lambda: _terms(record, drive.units)},
        "tables": {"rules": lambda: rules(table, "rule table", label)},
    }


def _terms(record: SlidingDesign, drive_units: dict[str, str]) -> Figure:
    """Draw the terms of the error and of its rate as straight lines between the centres."""
    places = np.array([-BEYOND * ZR, *range(-ZR, ZR + 1), BEYOND * ZR])
    named = dict(zip(LABELS, np.array(degrees(ARRAYS, places)), strict=True))
    panels = []
    for name in ("error", "error_rate"):
        side = _side(record, drive_units, name)
        values = places / (BEYOND * ZR) * side.ends[1]
        curves = {label: (values, membership) for label, membership in named.items()}
        panels.append(Panel(side.label, side.ends, curves))
    return terms(panels, "terms")


def phase_plane(
    record: SlidingDesign, drive_units: dict[str, str], name: str, error: Floats, rate: Floats
) -> Figure:
    """Draw rate over error (steps,) of an axis, the sliding surface and its boundary layer."""
    figure = framed(4.0, top=0.35)
    axes, surface = figure.subplots(), record.sliding
    error, rate = (drawable(values) for values in (error, rate))
    span = 1.05 * max(float(np.abs(error).max()), 1e-12 * record.largest_error)
    ends = np.array([-span, span])
    line, layer = -surface.slope * ends, surface.boundary_layer
    axes.fill_between(ends, line - layer, line + layer, color="0.88")
    axes.plot(ends, line, color=OTHER, lw=1.0, label="s = 0")
    axes.plot(error, rate, color=OWN, lw=0.7)
    most = 1.1 * max(float(np.abs(rate).max()), layer)
    axes.set(xlim=(-span, span), ylim=(-most, most))
    axes.set_title(f"phase plane of {name}", fontsize=11)
    x = f"error e [{drive_units['error']}]"
    finish(axes, f"rate de/dt [{drive_units['error_rate']}]", x)
    return figure


def over_time(moves: Floats, every: float, unit: str, title: str) -> Figure:
    """Draw moves (steps, 7, 7), one sample ``every`` [s]: columns are moments, rows are rules."""
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


ABOUT = (
    "The command is the output of the rules for the error and its rate, plus a switching "
    "part that pushes towards the surface s = de/dt + λe, in proportion to s within the "
    "boundary layer (Lin & Gai 2009, eq. 9 to 13). Each rule that fires moves by its "
    "share of the judgement, the last column of P with the error (eq. 14), and stays "
    "within its largest move."
)


class Learning(NamedTuple):
    """Signals and learned moves of an axis during the motion."""

    error: Floats  # (steps,)
    rate: Floats  # (steps,) rate of the error
    moves: Floats  # (steps, 7, 7) moves of the consequents from their designed values


def sections(record: SlidingDesign, shown: ReportContext) -> list[Section]:
    """Return a section on the controller, and one for each axis: phase plane and learning."""
    report = [_controller(record, shown)]
    drives = zip(shown.machine.drives, shown.parameters, strict=True)
    limits = [min(map(abs, drive.largest_commands(parameters))) for drive, parameters in drives]
    for limit, (axis, signals) in zip(limits, (shown.signals or {}).items(), strict=False):
        motion = learning(record, signals, limit)
        report.append(_learnt(record, shown, shown.called(axis), motion))
    return report


def learning(record: SlidingDesign, signals: dict[str, Floats], limit: float) -> Learning:
    """Return what the rules learn from the signals of an axis with this command limit."""
    moves = np.array([memory.moves for memory in memories(record, signals, limit)][:-1])
    return Learning(signals["error"], signals["error_rate"], moves)


def _controller(record: SlidingDesign, shown: ReportContext) -> Section:
    units, layer, adaptation = shown.units, record.sliding, record.adaptation
    error, rate, command = units["error"], units["error_rate"], units["command"]
    of_error, of_rate = record.judge()
    rows = [
        ("error of LP", record.largest_error, error),
        ("rate of LP", record.largest_error_rate, rate),
        ("slope of the surface, λ", layer.slope, "1/s"),
        ("switching part, k", layer.gain, command),
        ("boundary layer, φ", layer.boundary_layer, rate),
        ("adaptation, γ", adaptation.rate, f"{command}/{error}"),
        ("judgement of the error, P₂", of_error, "1/s"),
        ("judgement of its rate, P₂", of_rate, "1"),
        ("largest move of a rule", adaptation.largest_move, command),
    ]
    for name, value in dict(record.pid or {}).items():
        per = {"k_p": error, "k_i": f"({error} s)", "k_d": f"({rate})"}[name]
        rows.append((f"beside the rules, {name}", value, f"{command}/{per}"))
    cells = [[name, f"{value:.5g}", unit] for name, value, unit in rows]
    table = np.array(record.table())
    drawing = Drawing(
        rules(table, "initial rules", f"command [{command}]"),
        "Heat map of the rule table",
        "Rule table: the command for each pair of terms, from large negative (LN) to large "
        "positive (LP).",
    )
    drawn = _surface(record, shown, "initial surface", "before it learns")
    listing = Table("Scales, gains and limits.", ["parameter", "value", "unit"], cells)
    return Section("The controller", ABOUT, listing, [drawing, drawn])


def _learnt(record: SlidingDesign, shown: ReportContext, name: str, motion: Learning) -> Section:
    command = shown.units["command"]
    moved = record.with_moves(tuple(map(tuple, motion.moves[-1].tolist())))
    after, every = np.array(moved.table()), record.sample_time_s
    drawings = [
        Drawing(
            phase_plane(record, shown.units, name, motion.error, motion.rate),
            f"Error and its rate of {name} against the sliding surface",
            f"{name} in the phase plane: s = 0 is the line, the boundary layer grey. "
            "Beyond the layer the full k pushes.",
        ),
        Drawing(
            over_time(motion.moves, every, f"[{command}]", f"rules of {name} over time"),
            f"Moves of the rules of {name} over time",
            "How far each rule has moved: a block for each term of the error, with a row "
            "for each term of its rate, LN on top.",
        ),
        Drawing(
            rules(after, f"rules of {name} at the end", f"moved by [{command}]", motion.moves[-1]),
            f"Heat map of the learned rule table of {name}",
            f"Rule table of {name} at the end of the motion: the numbers are the commands "
            f"[{command}] by then, the colours how far they have moved.",
        ),
        _surface(moved, shown, f"surface of {name} at the end", f"of {name} at the end"),
    ]
    return Section(f"Learning of {name}", "", None, drawings)


def _surface(record: SlidingDesign, shown: ReportContext, title: str, when: str) -> Drawing:
    return surfaces.drawing(
        surface(record, shown.units, title),
        f"Control surface {when}: the output of the rules, without the switching part"
        + " and without the linear gains" * (record.pid is not None)
        + ".",
    )
