"""``hfc report DESIGN``: the page of a design without a run, and its parts for a paper."""

import json
import re
from xml.etree import ElementTree

import pytest
import tex
from report_pages import FILE, HOSTILE, NAME, SINE
from run_folders import hfc
from wording import refused_command

from hfc_design.files.loop_setup import load_design, own_scenario


@pytest.fixture(scope="module")
def scored(lone):
    """The figures of ``hfc score`` of the same design on the same scenario."""
    return json.loads(hfc("score", lone.parent / FILE, *SINE, "--json").stdout)


def test_its_figures_are_those_of_a_score(lone, scored):
    text = lone.read_text()
    assert f"{1e6 * scored['rms_error_rad']:.4g}</td>" in text
    assert "rms error [µrad]</th>" in text
    assert "<dt>source</dt>" in text
    assert "on the scenario <code>c-axis-sine</code>" in text
    assert f"--scenario c-axis-sine --set {SINE[3]}" in text
    for hostile in (HOSTILE, FILE):
        assert hostile not in text
    assert "&lt;b&gt;&amp;" in text


def test_it_has_the_parts_of_a_runs_page_without_the_search(lone):
    """What it does on other machines has been left out for it, see tests/published."""
    text = lone.read_text()
    assert re.findall("<h2>(.*?)</h2>", text) == [
        "What it does",
        "How good it is",
        "The controller",
        "Its units",
        "The loop",
        "How to reproduce it",
    ]
    assert text.index("<figure>") < text.index("<table>")
    assert "generations of the search" not in text
    assert "design.json" not in text  # there is no run folder


def test_every_figure_and_table_of_the_page_is_a_file(lone):
    """Twelve: response, errors, tree, four tables and surfaces, loop; 80 mm, letters of 7 to 9."""
    page, figures = lone.read_text(), list((lone.parent / "mine-figures").iterdir())
    assert len(figures) == page.count("<figure>") == 12
    assert len(list((lone.parent / "mine-latex").iterdir())) == page.count("<table>")
    for path in figures:
        root = ElementTree.parse(path).getroot()
        assert root.get("width") == f"{80 / 25.4 * 72:.6f}pt"
        sizes = {float(x) for x in re.findall(r"font(?:-size)?: ([\d.]+)px", path.read_text())}
        assert sizes, path
        assert 7 <= min(sizes) <= max(sizes) <= 9, path


def test_a_table_has_the_figures_of_a_score(lone, scored):
    rows = tex.rows((lone.parent / "mine-latex" / "scores.tex").read_text())
    assert {len(row) for row in rows} == {len(rows[0])}
    values = {row[0]: row[1] for row in rows[1:]}
    error, peak = values["rms error [µrad]"], values["peak voltage [V]"]
    assert float(error) == pytest.approx(1e6 * scored["rms_error_rad"], rel=1e-3)
    assert float(peak) == pytest.approx(scored["peak_voltage_V"], rel=1e-3)


def test_nothing_is_overwritten_without_force(lone):
    before = {path: path.read_bytes() for path in lone.parent.rglob("*") if path.is_file()}
    assert refused_command("report", lone.parent / FILE, "--out", lone).where == f"--out {lone}"
    (lone.parent / "other-figures").mkdir()
    arguments = ("report", NAME, "--out", lone.parent / "other.html", "--figures", "svg")
    assert refused_command(*arguments).where == f"--figures {lone.parent / 'other-figures'}"
    assert {path: path.read_bytes() for path in lone.parent.rglob("*") if path.is_file()} == before


def test_a_lone_design_is_shown_on_the_scenario_that_it_was_made_for():
    assert own_scenario(load_design(NAME), NAME).name == "c-axis-ramp"
    found = refused_command("report", NAME, "--scenario", "feed-drive-circle")
    assert found.startswith(f"hfc: design {NAME} ")
