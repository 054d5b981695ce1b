"""The report of a run that designs a feed drive's fuzzy controller, without the search."""

import re

import numpy as np
import pytest
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


def rows_of(page):
    """First cell -> the other cells of every table's rows."""
    rows = re.findall(r'<tr><th scope="row">(.*?)</th>(.*?)</tr>', page)
    return {name: re.findall(r'<td class="value">(.*?)</td>', rest) for name, rest in rows}


def holds_the_design(report):
    """What a page has to say of either kind."""
    (_, result, folder, _), page = report
    titles = re.findall("<h2>(.*?)</h2>", page)
    adapts = result.design.controller.kind == "aflc"
    assert ("What the adaptation made of it" in titles) == adapts
    assert titles[:3] == ["Can I use it?", "What it does", "How good it is"]
    assert titles[3:5] == ["On other machines", "The controller"]
    assert titles[-4:] == ["Stability", "The loop", "How it was found", "How to reproduce it"]
    assert page.count("<img") == (14 if adapts else 8)
    text = re.sub(r'src="[^"]*"', "", page).partition("Configuration")[0]
    for word in ("ierarch", "PD part", "pindle", "oltage", "Lin &amp; Lee", "structures"):
        assert word not in text
    rows = rows_of(page)
    assert rows["integral gain"] == ["0", "unit/(BLU s)"]
    assert float(rows["rms contour error [BLU]"][0]) == pytest.approx(
        result.evaluation.metrics["rms_contour_error_BLU"], rel=1e-3
    )
    if adapts:
        assert rows["step of an edge of an error term, k_a"] == ["0.5", "BLU"]
        assert rows["step of an edge of a term of the change, k_b"] == ["0.125", "BLU"]
        assert rows["step of a command in the rule table, k_c"] == ["1", "unit"]
        assert rows["limit of the adaptation, K₁"] == ["5.25", "unit/BLU"]
        assert rows["limit of the adaptation, K₂"] == ["3.5", "unit/BLU"]
        assert rows["limit of the adaptation"] == ["5.25", "3.5", "no"]
    # JK04 eq. 13: 32 units at 21 BLU; 16 at 14 and 8 at 7 are less
    assert rows["table, eq. 13 and 14"][0] == "1.524"
    assert (folder / "tables" / "rules.csv").exists()
