"""Figures and tables of pages for a paper: sizes, letters, texts, and where they lie."""

import json

import pytest
import tex
from click.testing import CliRunner

from hfc_design.cli import main
from hfc_design.files.pairing import load_design, own_scenario

NAME = "lin-lee-1999-table-1"
SHORT = "--set", "simulation.duration_s=0.2"


def hfc(*arguments):
    return CliRunner().invoke(main, [*map(str, arguments)])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """What ``hfc report`` of a design on another scenario than its own writes for a paper."""
    found = tmp_path_factory.mktemp("paper")
    done = hfc("report", NAME, "--scenario", "c-axis-sine", *SHORT, "--out", found / "sine.html",
               "--figures", "svg", "--width", "8cm", "--latex")  # fmt: skip
    assert done.exit_code == 0, done.output
    return found


def test_every_figure_and_table_of_the_page_is_a_file(folder):
    page = (folder / "sine.html").read_text()
    assert len(list((folder / "sine-figures").iterdir())) == page.count("<figure>") == 11
    assert len(list((folder / "sine-latex").iterdir())) == page.count("<table>") == 3
    assert "on the scenario <code>c-axis-sine</code>" in page
    assert f"hfc score {NAME} --scenario c-axis-sine --set simulation.duration_s=0.2" in page


def test_a_table_has_the_figures_of_a_score(folder):
    told = json.loads(hfc("score", NAME, "--scenario", "c-axis-sine", *SHORT, "--json").stdout)
    rows = tex.rows((folder / "sine-latex" / "scores.tex").read_text())
    assert {len(row) for row in rows} == {len(rows[0])}
    values = {row[0]: row[1] for row in rows[1:]}
    assert float(values["rms error [mrad]"]) == pytest.approx(1e3 * told["rms_error_rad"], rel=1e-3)
    peak = values["peak voltage [V]"]
    assert float(peak) == pytest.approx(told["peak_voltage_V"], rel=1e-3)


def test_the_scenario_of_a_lone_design_is_checked():
    design = load_design(NAME)
    assert own_scenario(design, NAME).name == "c-axis-ramp"
    done = hfc("report", NAME, "--scenario", "feed-drive-circle")
    assert done.exit_code == 2
    assert "is for the plant c-axis" in done.stderr
