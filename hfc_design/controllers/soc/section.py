"""Report sections and pictures of a self-organising controller: its rules while it learns."""

from math import inf

import numpy as np
from matplotlib.figure import Figure

from hfc_design.controllers import surfaces
from hfc_design.controllers.kind import ReportContext, memories
from hfc_design.controllers.rules import RuleUnit, Triangle
from hfc_design.controllers.soc.law import HIGHEST, LABELS, SETS, degrees
from hfc_design.controllers.soc.record import SocDesign
from hfc_design.controllers.surfaces import Side, Surface
from hfc_design.core.numbers import ARRAYS, Floats
from hfc_design.core.tables import Table
from hfc_design.plotting.figure import STRIP, colour_strip, framed
from hfc_design.plotting.heat_map import heat_map
from hfc_design.plotting.numbers import readable as in_unit
from hfc_design.plotting.section import Drawing, Drawn, Section
from hfc_design.plotting.terms import Panel, terms
from plants import Drive

#: Shares of the motion after which the rules are drawn.
SHARES = (0.02, 0.25, 1.0)


def sections(record: SocDesign, shown: ReportContext) -> list[Section]:
    """Return a section with gains and initial rules, and one with the rules that axes learned."""
    units = shown.units
    text = (
        f"Every {1e3 * record.sample_time_s:g} ms the control reads the error of each axis and its "
        f"change since the last sample, both in {SETS} sets from -{HIGHEST} to {HIGHEST}. Of the "
        f"{SETS} × {SETS} rules four fire; each is then corrected by the error and its change."
    )
    gains = record.law_gains()._asdict()
    meanings = {
        "ge": ("sets per unit of the error", f"1/{units['error']}"),
        "gc": ("sets per unit of its change in a sample", f"1/{units['error']}"),
        "gu": ("command of a rule of 1", units["command"]),
        "gamma": ("share of the error that a correction removes", "1"),
        "xi": ("weight of the change in a correction", "1"),
    }
    rows = [[f"{key}, {text}", f"{gains[key]:.5g}", unit] for key, (text, unit) in meanings.items()]
    listing = Table("Gains and steps.", ["parameter", "value", "unit"], rows)
    caption = "Control initial surface, before it learns."
    begins = [_surface(record, shown, "initial rules", caption)] if np.any(record.table) else []
    if not begins:
        text += " It starts with rules that command 0 everywhere."
    report = [Section("The controller", text, listing, begins)]
    if shown.signals:
        limits = shown.largest or (None,) * len(shown.signals)
        drawings: list[Drawing] = []
        for (axis, signals), limit in zip(shown.signals.items(), limits, strict=True):
            learned = learnt(record, signals, limit)
            drawings += _learning(record, shown, shown.called(axis), learned)
        text = "Each axis starts with the rules of the design and learns its own while it moves."
        report.append(Section("Learned rules", text, None, drawings))
    return report


def _learning(
    record: SocDesign, shown: ReportContext, axis: str, rules: dict[float, Floats]
) -> list[Drawing]:
    """Return pictures of the rules of an axis at several times, and their surface at the end."""
    end = record.model_copy(update={"table": tuple(map(tuple, [*rules.values()][-1].tolist()))})
    caption = f"Control surface of {axis} with the rules at the end of the motion."
    return [
        Drawing(
            tables(rules, record.law_gains().gu, axis, shown.units["command"]),
            f"Heat maps of the rules learned by {axis}",
            f"Rules of {axis} as it learns them; rows by the error, columns by its change.",
        ),
        _surface(end, shown, f"rules of {axis} at the end", caption),
    ]


def _surface(record: SocDesign, shown: ReportContext, title: str, caption: str) -> Drawing:
    return surfaces.drawing(surface(record, shown.units, title), caption)


def learnt(
    record: SocDesign, signals: dict[str, Floats], limit: float | None
) -> dict[float, Floats]:
    """Return {time [s]: rules (11, 11)} after each of ``SHARES`` of the motion."""
    moments = {max(round(share * len(signals["error"])), 1) for share in SHARES}
    each, every = enumerate(memories(record, signals, limit)), record.sample_time_s
    return {count * every: np.array(memory.rules) for count, memory in each if count in moments}


EDGES = np.arange(SETS + 1) - HIGHEST - 0.5


def surface(record: SocDesign, drive_units: dict[str, str], title: str) -> Surface:
    """Return the surface of the output of a record's table."""
    table, gains = np.array(record.table), record.law_gains()

    def law(change: Floats, error: Floats) -> Floats:
        in_change, in_error = (np.array(degrees(ARRAYS, x)) for x in (change, error[:, 0]))
        output: Floats = in_error.T @ table @ in_change
        return output

    change = _side("change of error in a sample", drive_units["error"], gains.gc)
    error = _side("error", drive_units["error"], gains.ge)
    unit = RuleUnit("rules", "error_change", "error", _sets(), _sets(), record.table)
    worth = gains.gu, drive_units["command"]
    return Surface(title, unit, change, error, "rules [1]", law, worth)


def _side(name: str, unit: str, gain: float) -> Side:
    """Return an input whose axis ends at the outermost sets; beyond them the output is constant."""
    factor, unit = in_unit(unit, HIGHEST / gain)
    end = factor * HIGHEST / gain
    return Side(name, unit, (-end, end), gain / factor)


def _sets() -> tuple[Triangle, ...]:
    ends = [-inf, *range(-HIGHEST, HIGHEST + 1), inf]
    return tuple(Triangle(label, *ends[k : k + 3]) for k, label in enumerate(LABELS))


def pictures(record: SocDesign, drive: Drive) -> dict[str, dict[str, Drawn]]:
    """Return pictures for ``hfc plot``: the rules in the record of the design."""
    empty = " at the start: it has learned none" * (not np.any(record.table))
    return {
        **surfaces.pictures({"rules": lambda: surface(record, drive.units, f"rules{empty}")}),
        "terms": {"rules": lambda: _terms(record, drive)},
        "tables": {"rules": lambda: _table(record, f"rules{empty}")},
    }


def _terms(record: SocDesign, drive: Drive) -> Figure:
    ends = (-HIGHEST, HIGHEST)
    values = np.linspace(*ends, 20 * HIGHEST + 1)
    each = zip(LABELS, np.array(degrees(ARRAYS, values)), strict=True)
    curves = {label: (values, membership) for label, membership in each}
    gains, unit = record.law_gains(), drive.units["error"]
    sides = {"error": gains.ge, "its change in a sample": gains.gc}.items()
    label = "; ".join(f"{name}, a set is {1.0 / gain:.3g} {unit}" for name, gain in sides)
    return terms([Panel(label, ends, curves)], "sets of both inputs")


def _table(record: SocDesign, title: str) -> Figure:
    names = "row: error [sets]", "column: change of error [sets]"
    return heat_map(np.array(record.table), (LABELS, LABELS), *names, title, "rule [1]")


def tables(by_time: dict[float, Floats], gu: float, axis: str, unit: str) -> Figure:
    """Draw the rules at several times [s] side by side, as commands in ``unit``."""
    figure = framed(2.3, top=0.35, right=STRIP)
    panels = figure.subplots(1, len(by_time), sharey=True, squeeze=False)[0]
    limit = gu * max(float(np.abs(rules).max()) for rules in by_time.values()) or 1.0
    for axes, (time, rules) in zip(panels, by_time.items(), strict=True):
        mesh = axes.pcolormesh(EDGES, EDGES, gu * rules, cmap="RdBu_r", vmin=-limit, vmax=limit)
        axes.set(xticks=(-HIGHEST, 0, HIGHEST), yticks=(-HIGHEST, 0, HIGHEST), aspect="equal")
        axes.set_title(f"{axis}, {time:.3g} s", fontsize=9)
        axes.set_xlabel("change [sets]", fontsize=8)
    panels[0].set_ylabel("error [sets]", fontsize=8)
    colour_strip(figure, panels[-1], mesh, f"command [{unit}]").outline.set_visible(False)
    return figure
