"""What an interpreter and a notebook show of a record is short, and nothing in it is markup."""

from html.parser import HTMLParser

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


class Cells(HTMLParser):
    def __init__(self):
        super().__init__()
        self.tags, self.texts = [], []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)

    def handle_data(self, data):
        self.texts.append(data)


def test_a_table_with_what_is_written_escaped(records):
    told = "<script>alert(1)</script> & more"
    scenario = records["Scenario"].model_copy(update={"description": told})
    page = Cells()
    page.feed(scenario._repr_html_())
    assert set(page.tags) == {"table", "caption", "tr", "th", "td"}
    assert told in page.texts


def test_tables_are_small(records):
    for record in records.values():
        assert len(record._repr_html_()) < 8000
    assert "rms_error_rad" in records["Evaluation"]._repr_html_()
