"""Pictures of a self-organising controller: its rules, its sets, what it commands."""

from math import inf

import numpy as np
from matplotlib.figure import Figure

from hfc_design.controllers import surfaces
from hfc_design.controllers.rules import RuleUnit, Triangle
from hfc_design.controllers.soc.law import HIGHEST, LABELS, SETS, degrees
from hfc_design.controllers.soc.record import SocDesign
from hfc_design.controllers.surfaces import Side, Surface
from hfc_design.core.numbers import ARRAYS, Floats
from hfc_design.pictures.figure import STRIP, colour_strip, framed
from hfc_design.pictures.heat_map import heat_map
from hfc_design.pictures.numbers import readable as in_unit
from hfc_design.pictures.section import Drawn
from hfc_design.pictures.terms import Panel, terms
from plants import Drive

EDGES = np.arange(SETS + 1) - HIGHEST - 0.5


def surface(record: SocDesign, drive_units: dict[str, str], title: str) -> Surface:
    """What the rules of a record say by now."""
    table, gains = np.array(record.table), record.gains()

    def law(change: Floats, error: Floats) -> Floats:
        in_change, in_error = (np.array(degrees(ARRAYS, x)) for x in (change, error[:, 0]))
        found: Floats = in_error.T @ table @ in_change
        return found

    change = _side("change of error in a sample", drive_units["error"], gains.gc)
    error = _side("error", drive_units["error"], gains.ge)
    unit = RuleUnit("rules", "error_change", "error", _sets(), _sets(), record.table)
    worth = gains.gu, drive_units["command"]
    return Surface(title, unit, change, error, "rules [1]", law, worth)


def _side(name: str, unit: str, gain: float) -> Side:
    """Up to the outermost sets: what is beyond counts as there."""
    factor, unit = in_unit(unit, HIGHEST / gain)
    end = factor * HIGHEST / gain
    return Side(name, unit, (-end, end), gain / factor)


def _sets() -> tuple[Triangle, ...]:
    ends = [-inf, *range(-HIGHEST, HIGHEST + 1), inf]
    return tuple(Triangle(label, *ends[k : k + 3]) for k, label in enumerate(LABELS))


def pictures(record: SocDesign, drive: Drive) -> dict[str, dict[str, Drawn]]:
    """For ``hfc plot``: the rules that the design has learnt, or begins with."""
    empty = " to begin with: it has learnt none" * (not np.any(record.table))
    return {
        **surfaces.pictures({"rules": lambda: surface(record, drive.units, f"rules{empty}")}),
        "terms": {"rules": lambda: _terms(record, drive)},
        "tables": {"rules": lambda: _table(record, f"rules{empty}")},
    }


def _terms(record: SocDesign, drive: Drive) -> Figure:
    ends = (-HIGHEST, HIGHEST)
    values = np.linspace(*ends, 20 * HIGHEST + 1)
    each = zip(LABELS, np.array(degrees(ARRAYS, values)), strict=True)
    curves = {label: (values, own) for label, own in each}
    gains, unit = record.gains(), drive.units["error"]
    told = (
        f"{name}, a set is {1.0 / gain:.3g} {unit}"
        for name, gain in (("error", gains.ge), ("its change in a sample", gains.gc))
    )
    return terms([Panel("; ".join(told), ends, curves)], "sets of both inputs")


def _table(record: SocDesign, title: str) -> Figure:
    names = "row: error [sets]", "column: change of error [sets]"
    return heat_map(np.array(record.table), (LABELS, LABELS), *names, title, "rule [1]")


def tables(found: dict[float, Floats], gu: float, axis: str, unit: str) -> Figure:
    """The rules side by side, as commands [unit]."""
    figure = framed(2.3, top=0.35, right=STRIP)
    panels = figure.subplots(1, len(found), sharey=True, squeeze=False)[0]
    limit = gu * max(float(np.abs(rules).max()) for rules in found.values()) or 1.0
    for axes, (time, rules) in zip(panels, found.items(), strict=True):
        mesh = axes.pcolormesh(EDGES, EDGES, gu * rules, cmap="RdBu_r", vmin=-limit, vmax=limit)
        axes.set(xticks=(-HIGHEST, 0, HIGHEST), yticks=(-HIGHEST, 0, HIGHEST), aspect="equal")
        axes.set_title(f"{axis}, {time:.3g} s", fontsize=9)
        axes.set_xlabel("change [sets]", fontsize=8)
    panels[0].set_ylabel("error [sets]", fontsize=8)
    colour_strip(figure, panels[-1], mesh, f"command [{unit}]").outline.set_visible(False)
    return figure
