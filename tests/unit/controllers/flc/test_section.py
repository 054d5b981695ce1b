"""The report of a run that designs a feed drive's fuzzy controller, and its pictures."""

import numpy as np
import pytest

from hfc_design.files.design import Design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.pairing import load_design
from hfc_design.report.page import write_page
from hfc_design.report.verdict import summary
from hfc_design.runs.run import Result, new_run
from hfc_design.search.loop import Archive, History, Search
from hfc_design.simulation.evaluating import evaluate

#: Steps of JK04 Table 3; a linear loop with the drive of fig. 10 is stable up to 5.156 unit/BLU.
ADAPTATION = {
    "k_a": 0.5,
    "k_b": 0.125,
    "k_c": 1.0,
    "stable_range": {"k1_max": 5.25, "k2_max": 3.5},
}


@pytest.fixture(scope="module", params=["flc", pytest.param("aflc", marks=pytest.mark.slow)])
def report(request, tmp_path_factory):
    """The arguments of ``write_page`` for each kind of design, and its page."""
    folder = tmp_path_factory.mktemp(request.param) / "run"
    changes = ["simulation.duration_s=4.0", f"controller.kind={request.param}"]
    scenario = new_run(load_scenario("feed-drive-circle", changes), folder)
    record = load_design(f"jee-koren-2004-{request.param}").model_dump()
    record["plant"]["parameters"] = {"gain": 40.0}
    if request.param == "aflc":
        record["controller"]["adaptation"] = ADAPTATION
    design = Design.model_validate(record)
    history = History(np.array([0.1]), np.array([0.1]), np.array([0]), np.array([1]))
    result = Result(
        design, evaluate(design, scenario), Search(1, None, Archive(None, None), history)
    )
    rivals = {name: evaluate(load_design(name), scenario) for name in ("jee-koren-2004-pid",)}
    arguments = scenario, result, folder, rivals
    write_page(*arguments)
    return arguments, (folder / "report.html").read_text()


def test_summary_compares_contour_errors(report):
    scenario, result, _, _ = report[0]

    def off(rms):
        return result.evaluation._replace(metrics={"rms_contour_error_BLU": rms})

    lost = off(None)._replace(diverged=True)
    published = {f"jee-koren-2004-{kind}": off(rms) for kind, rms in (("aflc", 1.0), ("flc", 5.0))}
    assert summary(scenario, off(2.0), published | {"jee-koren-2004-pid": lost}) == (
        "The controller reaches a contour error of 2 BLU rms on feed-drive-circle: that of the "
        "AFLC of Jee & Koren (2004) is 0.5 times as large (1 BLU), that of their FLC is 2.5 times "
        "as large (5 BLU) and their PID diverges there."
    )
    assert summary(scenario, off(2.0), {}).endswith("2 BLU rms on feed-drive-circle.")
    assert "diverges on feed-drive-circle" in summary(scenario, lost, published)


def flc():
    return load_design("jee-koren-2004-flc").controller
