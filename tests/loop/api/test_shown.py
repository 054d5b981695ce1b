"""What an interpreter and a notebook show of a record is short, and nothing in it is markup."""

import re

import pytest

from hfc_design import api as hfc
from hfc_design.batch.summary import Findings

SHORT = {"simulation.duration_s": 0.1}


@pytest.fixture(scope="module")
def records():
    scenario = hfc.load_scenario("c-axis-ramp", SHORT)
    design = hfc.load_design("pd-only")
    found = hfc.evaluate(design, scenario)
    beside = hfc.compare(["pd-only", "lin-lee-1999-table-1"], [scenario])
    spread = hfc.robustness(design, scenario, spread=0.1, samples=4)
    result = hfc.Result(design, found, None)
    return {
        "Robustness": spread,
        "Result": result,
        "Findings": Findings([], [], [], [], []),
        "Scenario": scenario,
        "Design": design,
        "Evaluation": found,
        "Comparison": beside,
    }


def test_numbers_are_those_of_the_record(records):
    found = records["Evaluation"]
    said = re.search(r"fitness=([^,]+), .*samples=(\d+)", repr(found))
    assert float(said[1]) == pytest.approx(found.fitness, rel=1e-3)
    assert int(said[2]) == 100  # 0.1 s in milliseconds


def test_a_picture_is_a_figure():
    figure = hfc.picture("lin-lee-1999-table-1", "surface", unit="unit-7")
    assert figure.axes[0].get_xlabel() == "spindle velocity [mrad/s]"
    with pytest.raises(hfc.UserError, match="no picture 'tree'"):
        hfc.picture("jee-koren-2004-flc", "tree")


def test_explain_is_a_sum_by_hand():
    """Of triangles that overlap at half, all shares are a product, and their sum is the output."""
    found = hfc.explain("jee-koren-2004-flc", {"error": 12, "error_change": 1.5})
    rules = found["units"][0]["rules"]
    assert sum(rule["share"] for rule in rules) == pytest.approx(1.0)
    said = sum(rule["share"] * rule["consequent"] for rule in rules)
    assert found["units"][0]["output"] == pytest.approx(said)
    assert hfc.explain("jee-koren-2004-flc", "error=12,error_change=1.5") == found
    with pytest.raises(hfc.UserError, match="sample is missing"):
        hfc.explain("jee-koren-2004-flc")
    with pytest.raises(hfc.UserError, match="mood"):
        hfc.explain("jee-koren-2004-flc", {"mood": 12})


def test_import_takes_back_what_was_exported(tmp_path):
    (file,) = hfc.export("jee-koren-2004-flc", "fll", tmp_path / "fll").glob("*.fll")
    found = hfc.import_(file, like="jee-koren-2004-flc")
    own = hfc.load_design("jee-koren-2004-flc")
    assert found.controller.rules.centroids == own.controller.rules.centroids
    with pytest.raises(hfc.UserError, match="no such option 'mood'"):
        hfc.import_(file, mood=1)
