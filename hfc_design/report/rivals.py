"""The page of a run beside the published designs."""

from pathlib import Path

from hfc_design.core.records import UserError
from hfc_design.files.pairing import load_design
from hfc_design.files.scenario import Scenario
from hfc_design.report.page import write_report
from hfc_design.runs.run import Result
from hfc_design.simulation.evaluation import Evaluation, evaluate

#: Plant -> designs shown beside every result, and their names in the table.
BASELINES = {
    "c-axis": {
        "lin-lee-1999-table-1": "LL Table I",
        "lin-lee-1999-table-2": "LL Table II",
        "pd-only": "PD only",
    },
    "feed-drive": {
        "jee-koren-2004-aflc": "JK04 AFLC",
        "jee-koren-2004-flc": "JK04 FLC",
        "jee-koren-2004-pid": "JK04 PID",
    },
}


def write_page(scenario: Scenario, result: Result, folder: Path) -> dict[str, Evaluation]:
    """Write the page of a run beside the published designs; returns what these do.

    Raises:
        RunError: the folder cannot be written.
    """
    baselines = BASELINES.get(scenario.plant.name, {})
    rivals = {name: rival for name in baselines if (rival := _rival(name, scenario))}
    write_report(scenario, result, rivals, folder)
    return rivals


def _rival(name: str, scenario: Scenario) -> Evaluation | None:
    """A published design on this scenario; None where it does not fit the plant or sampling."""
    try:
        return evaluate(load_design(name), scenario)
    except UserError:
        return None
