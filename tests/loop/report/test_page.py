from html.parser import HTMLParser

import pytest

from hfc_design.core.records import RunError
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.pairing import load_design
from hfc_design.report.page import write_page
from hfc_design.runs.run import Result, new_run
from hfc_design.simulation.evaluating import evaluate


class Page(HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.tags, self.addresses, self.images = [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        found = dict(attributes)
        self.tags.append(tag)
        self.addresses += [found[key] for key in ("src", "href", "xlink:href") if key in found]
        if tag == "img":
            self.images.append(found)


def test_report_escapes_what_a_user_wrote(report):
    text = report[1].read_text()
    tags = Page(text).tags
    assert tags.count("script") == 5  # the page's own, and numbers of four units
    assert tags.count("img") == tags.count("figure") == 12
    assert text.count("&lt;script&gt;") == 3  # description, configuration, provenance


def test_same_run_gives_the_same_bytes(report):
    arguments, path = report
    first = path.read_bytes()
    write_page(*arguments)
    assert path.read_bytes() == first


def test_tables_are_not_written_through_a_link(tmp_path):
    """It may lead to tables of others, which have the same names."""
    folder = tmp_path / "run"
    scenario = new_run(load_scenario("c-axis-ramp", {"simulation.duration_s": 0.1}), folder)
    design, others = load_design("lin-lee-1999-table-1"), tmp_path / "others"
    others.mkdir()
    (others / "manifest.csv").write_text("precious")
    (folder / "tables").symlink_to(others)
    result = Result(design, evaluate(design, scenario), None)
    with pytest.raises(RunError, match="is a link"):
        write_page(scenario, result, folder, {})
    assert [file.read_text() for file in others.iterdir()] == ["precious"]
