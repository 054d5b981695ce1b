"""The report of a run that designs a feed drive's fuzzy controller, without the search."""

import numpy as np
from report_pages import write

from hfc_design.files.design import Design
from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario
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


def reported(kind, folder, rival="jee-koren-2004-pid"):
    """The arguments of ``write`` for a kind of design, beside a rival, and its page."""
    changes = ["simulation.duration_s=4.0", f"controller.kind={kind}"]
    scenario = new_run(load_scenario("feed-drive-circle", changes), folder)
    record = load_design(f"jee-koren-2004-{kind}").model_dump()
    record["plant"]["parameters"] = {"gain": 40.0}
    if kind == "aflc":
        record["controller"]["adaptation"] = ADAPTATION
    design = Design.model_validate(record)
    history = History(np.array([0.1]), np.array([0.1]), np.array([0]), np.array([1]))
    result = Result(
        design, evaluate(design, scenario), Search(1, None, Archive(None, None), history)
    )
    rivals = {rival: evaluate(load_design(rival), scenario)}
    arguments = scenario, result, folder, rivals
    write(*arguments)
    return arguments, (folder / "report.html").read_text()
