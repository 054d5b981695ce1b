"""A report that the tests of its page, its plots and its tables look at."""

import json

import pytest


@pytest.fixture(scope="session")
def report(tmp_path_factory):
    """The arguments of ``write_page``, and the report that it wrote."""
    # Late: these draw.
    from random_runs import HOSTILE, design, finished

    from hfc_design.files.named_scenario import load_scenario
    from hfc_design.files.pairing import load_design
    from hfc_design.report.page import write_page
    from hfc_design.runs.run import Result, new_run
    from hfc_design.simulation.evaluating import evaluate

    folder = tmp_path_factory.mktemp("report") / "run"
    changes = ("simulation.duration_s=0.5", f"description={json.dumps(HOSTILE)}")
    scenario = new_run(load_scenario("c-axis-ramp-cutting", changes), folder)
    found = design(5, tree=40)
    names = ("lin-lee-1999-table-1", "lin-lee-1999-table-2", "pd-only")
    rivals = {name: evaluate(load_design(name), scenario) for name in names}
    result = Result(found, evaluate(found, scenario), finished(5))
    write_page(scenario, result, folder, rivals)
    return (scenario, result, folder, rivals), folder / "report.html"
