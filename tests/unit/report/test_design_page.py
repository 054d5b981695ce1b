"""``hfc report DESIGN``: the page of a design without a run."""

import json
from pathlib import Path

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


def test_nothing_is_overwritten(page):
    again = hfc("report", page.parent / FILE, "--out", page)
    assert again.exit_code == 2
    assert "exists already" in again.stderr


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        ((NAME, "--each"), "is a design; --each and --parquet are for folders of runs"),
        (("none",), "none: is no folder, no design file and no built-in design"),
        ((".", "--out", "x.html"), "is for a lone design"),
    ],
)
def test_what_does_not_go_together_is_a_line(arguments, why, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = hfc("report", *arguments)
    assert done.exit_code == 2
    assert why in done.stderr
    assert done.stderr.count("\n") == 1
    assert not list(Path().iterdir())
