"""Draws the pictures of docs/concepts.md with the tool's own drawings: ``pictures.py RUN FOLDER``.

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
from hfc_design.plotting.files import save
from hfc_design.report import plots, searches
from hfc_design.report.errors import errors
from hfc_design.runs.run import finished_run
from plants import C_AXIS

PUBLISHED = "lin-lee-1999-table-1"


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
        "fitness": errors({"designed": result.evaluation, **ramp}),
    }


if __name__ == "__main__":
    for name, figure in drawn(Path(sys.argv[1])).items():
        save(figure, Path(sys.argv[2]) / f"{name}.svg")
