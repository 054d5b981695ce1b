"""What an interpreter and a notebook show of a record is short, and nothing in it is markup."""

import pytest
from wording import refused

from hfc_design import api as hfc
from hfc_design.batch.findings import Findings

KINDS = ["Scenario", "Design", "Evaluation", "Comparison", "Result", "Robustness", "Findings"]


@pytest.fixture(scope="module")
def records():
    scenario = hfc.load_scenario("c-axis-ramp", {"simulation.duration_s": 0.1})
    design = hfc.load_design("pd-only")
    found = hfc.evaluate(design, scenario)
    soft = hfc.load_design(design, {"name": "soft", "controller.pd.kp": 900.0})
    every = [scenario, design, found, hfc.compare([design, soft], [scenario], machines=4)]
    every += [hfc.Result(design, found, None), hfc.robustness(design, scenario, 0.1, samples=4)]
    return dict(zip(KINDS, [*every, Findings([], [], [], [], [])], strict=True))


@pytest.mark.parametrize("kind", KINDS)
def test_a_line_that_says_what_it_is_and_a_small_table(records, kind):
    text = repr(records[kind])
    assert text.startswith(f"{kind}(")
    assert "\n" not in text
    assert len(text) < 250
    assert len(str(records[kind])) < 250
    assert len(records[kind]._repr_html_()) < 8000


def test_a_picture_is_a_figure():
    figure = hfc.picture("lin-lee-1999-table-1", "surface", unit="unit-7")
    assert figure.axes[0].get_xlabel() == "spindle velocity [mrad/s]"
    with refused():
        hfc.picture("jee-koren-2004-flc", "tree")


def test_explain_is_a_sum_by_hand():
    """Of triangles that overlap at half, all shares are a product, and their sum is the output."""
    found = hfc.explain("jee-koren-2004-flc", {"error": 12, "error_change": 1.5})
    rules = found["units"][0]["rules"]
    assert sum(rule["share"] for rule in rules) == pytest.approx(1.0)
    said = sum(rule["share"] * rule["consequent"] for rule in rules)
    assert found["units"][0]["output"] == pytest.approx(said)
    assert hfc.explain("jee-koren-2004-flc", "error=12,error_change=1.5") == found
    for samples in ([], [{"mood": 12}]):
        with refused():
            hfc.explain("jee-koren-2004-flc", *samples)
