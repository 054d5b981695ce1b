"""What an interpreter and a notebook show of a record is short, and nothing in it is markup."""

import pytest

from hfc_design import api as hfc
from hfc_design.batch.summary import Findings

KINDS = ["Scenario", "Design", "Evaluation", "Comparison", "Result", "Robustness", "Findings"]
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


@pytest.mark.parametrize("kind", KINDS)
def test_a_line_that_says_what_it_is(records, kind):
    text = repr(records[kind])
    assert text.startswith(f"{kind}(")
    assert "\n" not in text
    assert len(text) < 250
    assert len(str(records[kind])) < 250
