"""Figures of the page of Jee & Koren 2004 (JK04), of the runs on one plant; see ``page``."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from experiments.shared import Batch, Floats, curves
from hfc_design.controllers.flc.rules import LABELS
from hfc_design.core.records import ZR
from hfc_design.files.loop_setup import load_design
from hfc_design.plotting.figure import OTHER, OWN, framed
from hfc_design.simulation.evaluating import Evaluation

CONTOUR = "contour error [BLU]"
AXIAL = "axial error X [BLU]"
STEP = 20.0  # of step.toml [BLU]
#: Rule bases of the paper with the printed singletons, built in or beside this file.
BASES = {"I": "jee-koren-2004-flc", "II": "base-2.json", "III": "base-3.json"}


def base_files() -> dict[str, str]:
    """Where the rule bases are."""
    here = Path(__file__).parent
    return {k: str(here / name) if name.endswith(".json") else name for k, name in BASES.items()}


def circle(batch: Batch) -> Figure:
    """Fig. 10: circle of 40 mm, three cycles."""
    found = {name: batch.motion(name) for name in ("FLC", "AFLC")}
    return errors(found, {AXIAL: {"RMS of the FLC in the paper": 16.2}})


def line(batch: Batch) -> Figure:
    """Fig. 11: line at 26.6 deg."""
    found = {name: batch.motion(f"line, {name}") for name in ("FLC", "AFLC")}
    return errors(found, {CONTOUR: {"FLC in the paper": 5.0}})


def errors(found: Mapping[str, Evaluation], levels: Mapping[str, Mapping[str, float]]) -> Figure:
    """Axial and contour errors."""
    panels = {
        AXIAL: {k: item.axes[0].motion.error for k, item in found.items()},
        CONTOUR: {k: item.contour.error for k, item in found.items()},
    }
    return curves(found["FLC"].time, panels, levels)


def friction(batch: Batch) -> Figure:
    """Fig. 12: circle of 20 mm with and without friction; the third cycle."""
    kinds = {"with friction": "", "without": ", no friction"}
    panels: dict[str, dict[str, Floats]] = {}
    for name in ("AFLC", "PID"):
        panel = panels[f"contour error, {name} [BLU]"] = {}
        for words, kind in kinds.items():
            found = batch.motion(f"slow circle, {name}{kind}")
            last = found.time >= 40.0
            panel[words] = found.contour.error[last]
    levels = {"contour error, PID [BLU]": {"PID in the paper": 15.6}}
    return curves(found.time[last], panels, levels)


def steep_line(batch: Batch) -> Figure:
    """Figs. 13 and 16b: line y = 10 x."""
    pairs = {"FLC": "machine, line, FLC", "AFLC": "machine, line, AFLC", "PID": "line, PID"}
    found = {name: batch.motion(label) for name, label in pairs.items()}
    seen = {name: item.contour.error for name, item in found.items()}
    panels = {
        f"fig. 13: {CONTOUR}": {name: seen[name] for name in ("FLC", "AFLC")},
        f"fig. 16b: {CONTOUR}": {name: seen[name] for name in ("PID", "AFLC")},
    }
    return curves(found["PID"].time, panels)


def machine_circle(batch: Batch) -> Figure:
    """Fig. 16a: circle of 20 mm; the third cycle, in which the AFLC is tuned."""
    pairs = {"PID": "slow circle, PID", "AFLC": "machine, slow circle, AFLC"}
    found = {name: batch.motion(label) for name, label in pairs.items()}
    last = found["PID"].time >= 40.0
    panel = {name: item.contour.error[last] for name, item in found.items()}
    return curves(found["PID"].time[last], {CONTOUR: panel})


def slot(batch: Batch) -> Figure:
    """Fig. 15: slotting."""
    found = batch.motion("slot, AFLC")
    return curves(found.time, {CONTOUR: {"AFLC in a slot": found.contour.error}})


def steps(batch: Batch) -> Figure:
    """Fig. 18: step responses of the rule bases."""
    names = [f"rule base {base}" for base in BASES]
    found = {name: batch.motion(f"step, {name}") for name in names}
    position = {name: item.axes[0].motion.state.position for name, item in found.items()}
    label = "position [BLU]"
    return curves(found[names[0]].time, {label: position}, {label: {"reference": STEP}})


def derivative_parts(design: str) -> tuple[Floats, Floats]:
    """Centres of the change of error (7,) [BLU], and u_2 there (4, 7) [unit] for E_0 to E_3."""
    record = load_design(design).controller
    table = np.array(record.rules.centroids)
    changes = np.array([term.centre for term in record.error_change_terms])
    return changes, (table - table[:, [ZR]])[ZR:]


def derivatives(places: Mapping[str, str]) -> Figure:
    """Fig. 17: what each rule base of ``places`` adds for the change of error."""
    figure = framed(5.0, top=0.35)
    grid = figure.subplots(len(places), 1, sharex=True, sharey=True)
    styles = zip(("black", OWN, OTHER, "#009E73"), ("-", "--", "-.", ":"), strict=True)
    marks = dict(zip(LABELS[ZR:], styles, strict=True))
    for axes, (base, design) in zip(grid, places.items(), strict=True):
        changes, parts = derivative_parts(design)
        for (label, (color, style)), part in zip(marks.items(), parts, strict=True):
            axes.plot(changes, part, color=color, ls=style, lw=1.4, label=label)
        axes.set_ylabel(f"base {base}: $u_2$ [unit]")
        axes.grid(color="0.9")
    grid[-1].set_xlabel("change of error [BLU per sample]")
    figure.legend(
        *grid[0].get_legend_handles_labels(), fontsize=9, frameon=False, ncols=4, loc="upper center"
    )
    return figure
