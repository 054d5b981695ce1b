"""``hfc report DESIGN``: the page of a design without a run."""

import json
import re

import pytest
from click.testing import CliRunner

from hfc_design.cli import main
from hfc_design.files.design import design_json
from hfc_design.files.pairing import load_design

NAME = "lin-lee-1999-table-1"
HOSTILE, FILE = '<script>alert("1")</script>', "<b>&'.json"


def hfc(*arguments):
    return CliRunner().invoke(main, [*map(str, arguments)])


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """The page of a design file of a hostile name, on a short motion."""
    record = json.loads(design_json(load_design(NAME)))
    record["provenance"]["scenario"] = {
        "name": "short",
        "description": HOSTILE,
        "plant": {"name": "c-axis"},
        "simulation": {"duration_s": 0.2},
        "reference": {"kind": "ramp"},
        "controller": {"kind": "pd+hierarchical-fuzzy"},
    }
    folder = tmp_path_factory.mktemp("lone")
    (folder / FILE).write_text(json.dumps(record))
    done = hfc("report", folder / FILE, "--out", folder / "mine.html")
    assert done.exit_code == 0, done.output
    assert done.stdout == f"{folder / 'mine.html'}\n"
    return folder / "mine.html"


def test_it_has_the_parts_of_a_runs_page_without_the_search(page):
    text = page.read_text()
    assert re.findall("<h2>(.*?)</h2>", text) == [
        "Can I use it?",
        "What it does",
        "How good it is",
        "On other machines",
        "The controller",
        "Its units",
        "How to run it again",
    ]
    assert text.count("<figure>") == 11  # response, errors, a tree, four tables and surfaces
    assert text.index("<figure>") < text.index("<table>")
    assert "generations of the search" not in text
    assert "design.json" not in text  # there is no run folder
