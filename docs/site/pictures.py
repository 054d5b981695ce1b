"""Draws pictures of docs/concepts.md and docs/scenario.md: ``pictures.py RUN FOLDER``.

RUN is a finished ``hfc design c-axis-ramp --seed 1``. The picture of a report,
docs/pictures/report.png, is a browser's, of the run of ``make design``: see docs/development.md.
"""

import sys
from pathlib import Path

from matplotlib.figure import Figure

import hfc_design.api as hfc
from hfc_design.controllers.flc.section import rule_table, surface
from hfc_design.controllers.hierarchical.drawn_tree import drawn_tree
from hfc_design.controllers.surfaces import flat
from hfc_design.plotting.figure import finish, framed
from hfc_design.plotting.files import save
from hfc_design.report import plots, searches
from hfc_design.report.errors import errors
from hfc_design.runs.run import finished_run
from plants import C_AXIS

PUBLISHED = "lin-lee-1999-table-1"


#: References of examples/shapers.toml, and a regulator that holds the motor almost still.
REFERENCES = {
    "trapezoid": {},
    "S-curve": {"reference.jerk": 450.0},
    "ZV": {"shaper": {"kind": "zv", "hz": 11.25}},
}
AHEAD = {"velocity": 37.0}
GAINS = {"kp": 273000.0, "kd": 2970.0, "signals": {"current": -75.3}}


def shaped() -> Figure:
    """The velocity of each reference, and how far the load behind the belt is from its goal."""
    figure = framed(3.6, 0.3)
    above, below = figure.subplots(2, sharex=True)
    for name, changes in REFERENCES.items():
        scenario = hfc.load_scenario("examples/quick_move.toml", changes)
        design = hfc.with_gains(scenario, "lqi", GAINS | {"feed_forward": AHEAD})
        motion = hfc.evaluate(design, scenario)
        (axis,) = motion.axes
        above.plot(motion.time, axis.happens.reference_rate, label=name, lw=1.0)
        off = axis.reference - axis.motion.error - scenario.reference.distance
        below.plot(motion.time, 1e3 * off, lw=1.0)
    below.set_ylim(-22.0, 22.0)
    above.legend(loc="upper right", frameon=False)
    finish(above, "reference [rad/s]")
    finish(below, "load - goal [mrad]", "time [s]")
    return figure


def drawn(run: Path) -> dict[str, Figure]:
    """Name of the file -> picture."""
    scenario, result = finished_run(run)
    unit = hfc.load_design("jee-koren-2004-flc")
    ramp = {name: hfc.evaluate(name, scenario) for name in (PUBLISHED, "pd-only")}
    return {
        "drive": plots.motion(ramp[PUBLISHED], f"{PUBLISHED} on {scenario.name}"),
        "rules": rule_table(unit.controller, f"rules of {unit.name}"),
        "surface": flat(surface(unit.controller, "what they command, between them too")),
        "hierarchy": drawn_tree(hfc.load_design(PUBLISHED).controller, C_AXIS),
        "search": searches.history(result.search.history, scenario.judge().title),
        "shapers": shaped(),
        "fitness": errors({"designed": result.evaluation, **ramp}),
    }


if __name__ == "__main__":
    for name, figure in drawn(Path(sys.argv[1])).items():
        save(figure, Path(sys.argv[2]) / f"{name}.svg")
