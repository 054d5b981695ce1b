"""The page of a run: it stands alone, is small, and says what was found."""

import base64
import json
import re
from xml.etree import ElementTree

import numpy as np
import pytest
import tex
from html_page import Page
from read_figures import lines_of
from report_pages import FILE, HOSTILE, NAME, SINE, write
from run_folders import hfc
from wording import refused, refused_command

from hfc_design.core.records import RunError
from hfc_design.files.loop_setup import load_design, own_scenario
from hfc_design.plotting.curves import SLICES
from hfc_design.plotting.files import image, save
from hfc_design.report import plots
from hfc_design.report.errors import motion_errors
from hfc_design.simulation.evaluating import evaluate


def test_it_tells_fitness_rivals_and_structures(report):
    (scenario, result, folder, rivals), path = report
    text = path.read_text()
    assert f"{result.evaluation.fitness:.1f} on {scenario.name}" in text
    for evaluation in (result.evaluation, *rivals.values()):
        assert f"{evaluation.fitness:.4f}" in text
    assert "73 individuals diverged" in text
    assert text.count('</th><td class="value">110.0</td>') == 1
    assert len(re.findall(r'<tr><th scope="row">\(', text)) == 10
    assert sorted(file.name for file in (folder / "tables").iterdir()) == sorted(
        ["manifest.csv", *(f"unit-{unit.id}.csv" for unit in result.design.controller.units)]
    )


def test_it_stands_alone_is_small_and_escapes_what_a_user_wrote(report):
    text = report[1].read_text()
    page = Page(text)
    assert len(text) < 1_000_000
    assert page.addresses
    assert all(address.startswith("data:") for address in page.addresses)
    assert "url(" not in text
    assert "@import" not in text
    assert not page.of("link")
    assert len(page.of("script")) == 5  # the page's own, and numbers of four units
    assert len(page.of("img")) == len(page.of("figure")) == 13
    for picture, _ in page.of("img"):
        drawing = base64.b64decode(picture["src"].partition(",")[2]).decode()
        assert all(address.startswith(("#", "data:")) for address in Page(drawing).addresses)
        assert picture["alt"]
    assert text.count("&lt;script&gt;") == 3  # description, configuration, provenance


def test_the_same_run_gives_the_same_bytes(report):
    arguments, path = report
    first = path.read_bytes()
    write(*arguments)
    assert path.read_bytes() == first


def test_whether_it_can_be_used(report):
    text = report[1].read_text()
    places = [text.index(part) for part in ("Can I use it?", "only 99.6 %", "<img", "<table")]
    assert places == sorted(places)  # the answer, the picture that shows it, and then tables
    part = text[text.index("On other machines") : text.index("The controller</h2>")]
    heads = re.findall(r'<th scope="col"[^>]*>(.*?)</th>', part)
    assert heads[1:3] == ["pass [%]", "settled rms error [µrad]"]
    rows = re.findall(r'<tr><th scope="row">(.*?)</tr>', part)
    cells = [re.split("<[^>]+>", row)[0::2] for row in rows]
    assert [cell[0] for cell in cells] == ["ramp *", "position"]
    assert part.count("* is required on the nominal machine only.") == 1
    assert "passes with the command multiplied by 0.455 to at least 16." in part
    assert cells[0][1:4] == ["100", "3.57 / 3570", "3.79 / 3790"]
    assert cells[1][1:3] == ["99.8", "7.14 / 7140"]
    named = re.findall("<dt>(.*?)</dt>", part)  # every reason that follows is explained
    assert {*named} >= {"is far off", "oscillates", "stays at a limit"}
    (why,) = re.findall("<li>(.*?)</li>", part)  # of those motions that some do not keep
    assert why == "position: 2 oscillate, 2 exceed unsettled, 1 is far off, 1 stays at a limit"


def test_tables_are_not_written_through_a_link(report, tmp_path):
    """It may lead to tables of others, which have the same names."""
    (scenario, result, _, _), _ = report
    folder, others = tmp_path / "run", tmp_path / "others"
    folder.mkdir()
    others.mkdir()
    (others / "manifest.csv").write_text("precious")
    (folder / "tables").symlink_to(others)
    with refused(RunError) as found:
        write(scenario, result, folder, {})
    assert found.where == str(folder / "tables")
    assert [file.read_text() for file in others.iterdir()] == ["precious"]


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


def test_errors_beside_rivals_in_every_motion():
    """A panel each, in its own unit; curves are the largest errors in slices of the time."""
    moves = [{"name": "ramp"}, {"name": "creep", "duration_s": 0.2}, {"name": "c", "weight": 2.0}]
    scenario = {"name": "three", "simulation": {"duration_s": 0.3}, "motions": moves}
    softer = load_design("pd-only", ["controller.pd.kp=1000"])
    both = {"pd-only": evaluate("pd-only", scenario), "softer": evaluate(softer, scenario)}
    figure = motion_errors(both)
    shown = [axes for axes in figure.axes if axes.get_visible()]
    assert [axes.get_title("left") for axes in shown] == ["ramp", "creep", "c"]
    assert len(figure.axes) == 4  # the place of a fourth stays empty
    for axes, (name, one) in zip(shown, both["pd-only"].motions.items(), strict=True):
        lines, (axis,) = lines_of(axes), one.axes
        assert list(lines) == [*both]
        unit = axes.get_title("right")
        factor = {"error [mrad]": 1e3, "error [µrad]": 1e6}[unit]
        assert lines["pd-only"][1].max() == pytest.approx(factor * abs(axis.motion.error).max())
        other = both["softer"].motions[name].axes[0].motion.error
        assert lines["softer"][1].max() == pytest.approx(factor * abs(other).max())
    assert image(figure, "png").startswith(b"\x89PNG")


def changed(evaluation, **axis):
    """The evaluation with parts of its only axis replaced."""
    return evaluation._replace(axes=(evaluation.axes[0]._replace(**axis),))


def moving(evaluation, values):
    """The motion of its only axis with these values (steps,) for everything."""
    motion = evaluation.axes[0].motion
    state = type(motion.state)(*[values] * len(motion.state))
    return motion._replace(error=values, command=values, state=state)


def test_long_curves_keep_their_peaks(report):
    evaluation = report[0][1].evaluation
    time = 1e-5 * np.arange(100_001)
    error = np.sin(time)
    error[[777, 54_321, -1]] = 5.0, -7.0, 3.0
    long = changed(
        evaluation._replace(time=time),
        happens=evaluation.axes[0].happens._replace(reference=time, loads=[0 * time]),
        motion=moving(evaluation, error),
    )
    line = plots.response(long, "long").axes[1].lines[0]
    assert len(line.get_xdata()) <= 2 * SLICES + 2
    assert np.all(np.diff(line.get_xdata()) > 0)
    assert {5.0, -7.0, 3.0} <= set(line.get_ydata())  # in rad, as no mrad is read so far


@pytest.mark.parametrize(
    ("suffix", "magic"), [("png", b"\x89PNG"), ("PDF", b"%PDF"), ("svg", b"<?xml")]
)
def test_a_picture_is_saved_and_the_same_each_time(report, tmp_path, suffix, magic):
    path, found = tmp_path / f"plot.{suffix}", []
    for _ in range(2):
        save(plots.response(report[0][1].evaluation, "title"), path)
        found.append(path.read_bytes())
    assert found[0].startswith(magic)
    assert found[0] == found[1]
