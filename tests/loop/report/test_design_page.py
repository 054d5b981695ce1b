"""``hfc report DESIGN``: the page of a design without a run."""

import json

import pytest
from click.testing import CliRunner

from hfc_design.cli import main
from hfc_design.files.design import design_json
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.pairing import load_design
from hfc_design.report.parts import everything

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


def test_its_figures_are_those_of_a_score(page):
    told = json.loads(hfc("score", page.parent / FILE, "--json").stdout)
    text = page.read_text()
    assert f"{1e3 * told['rms_error_rad']:.4g}</td>" in text
    assert "rms error [mrad]</th>" in text
    assert "<dt>source</dt>" in text
    for hostile in (HOSTILE, FILE):
        assert hostile not in text
    assert "&lt;b&gt;&amp;" in text


def test_the_page_says_what_everything_is():
    units = {"late_error": "2 mrad", "stick_slip": 0.0}
    asked = load_scenario("c-axis-ramp", {f"constraints.{key}": x for key, x in units.items()})
    assert everything(asked) == (
        "the loop is stable, and has at most late_error of 0.002 [rad], stick_slip of 0 [1]"
    )
    assert "no constraints" in everything(load_scenario("feed-drive-circle"))
