"""The report of a run that designs a feed drive's fuzzy controller, and its pictures."""

import re

import feed_oracle
import numpy as np
import pytest
from feed_oracle import verdict_jk04
from jk04 import CHANGE_TERMS, ERROR_TERMS, rule_singletons

from hfc_design.controllers.aflc.section import at_the_end
from hfc_design.controllers.flc import pictures as fuzzy_plots
from hfc_design.controllers.flc.record import FlcDesign
from hfc_design.controllers.flc.rules import LABELS
from hfc_design.controllers.kind import Shown
from hfc_design.controllers.surfaces import flat
from hfc_design.files.design import Design
from hfc_design.files.machine import SensorSettings
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.pairing import load_design
from hfc_design.report.page import write_page
from hfc_design.report.parts import sections
from hfc_design.runs.run import Result, new_run
from hfc_design.runtime import Controller
from hfc_design.search.loop import Archive, History, Search
from hfc_design.simulation.evaluating import evaluate

INFINITY = float("inf")
#: Steps of JK04 Table 3; a linear loop with the drive of fig. 10 is stable up to 5.156 unit/BLU.
ADAPTATION = {
    "k_a": 0.5,
    "k_b": 0.125,
    "k_c": 1.0,
    "stable_range": {"k1_max": 5.25, "k2_max": 3.5},
}


@pytest.fixture(scope="module", params=["flc", pytest.param("aflc", marks=pytest.mark.slow)])
def report(request, tmp_path_factory):
    """The arguments of ``write_page`` for each kind of design, and its page."""
    folder = tmp_path_factory.mktemp(request.param) / "run"
    changes = ["simulation.duration_s=4.0", f"controller.kind={request.param}"]
    scenario = new_run(load_scenario("feed-drive-circle", changes), folder)
    record = load_design(f"jee-koren-2004-{request.param}").model_dump()
    record["plant"]["parameters"] = {"gain": 40.0}
    if request.param == "aflc":
        record["controller"]["adaptation"] = ADAPTATION
    design = Design.model_validate(record)
    history = History(np.array([0.1]), np.array([0.1]), np.array([0]), np.array([1]))
    result = Result(
        design, evaluate(design, scenario), Search(1, None, Archive(None, None), history)
    )
    rivals = {name: evaluate(load_design(name), scenario) for name in ("jee-koren-2004-pid",)}
    arguments = scenario, result, folder, rivals
    write_page(*arguments)
    return arguments, (folder / "report.html").read_text()


def rows_of(page):
    """First cell -> the other cells of every table's rows."""
    rows = re.findall(r'<tr><th scope="row">(.*?)</th>(.*?)</tr>', page)
    return {name: re.findall(r'<td class="value">(.*?)</td>', rest) for name, rest in rows}


def test_page_holds_the_design(report):
    (_, result, folder, _), page = report
    titles = re.findall("<h2>(.*?)</h2>", page)
    adapts = result.design.controller.kind == "aflc"
    assert ("What the adaptation made of it" in titles) == adapts
    assert titles[:3] == ["Can I use it?", "What it does", "How good it is"]
    assert titles[3:5] == ["On other machines", "The controller"]
    assert titles[-3:] == ["Stability", "How it was found", "How to run it again"]
    assert page.count("<img") == (13 if adapts else 7)
    text = re.sub(r'src="[^"]*"', "", page).partition("Configuration")[0]
    for word in ("ierarch", "PD part", "pindle", "oltage", "Lin &amp; Lee", "structures"):
        assert word not in text
    rows = rows_of(page)
    assert rows["integral gain"] == ["0", "unit/(BLU s)"]
    assert float(rows["rms contour error [BLU]"][0]) == pytest.approx(
        result.evaluation.metrics["rms_contour_error_BLU"], rel=1e-3
    )
    if adapts:
        assert rows["step of an edge of an error term, k_a"] == ["0.5", "BLU"]
        assert rows["step of an edge of a term of the change, k_b"] == ["0.125", "BLU"]
        assert rows["step of a command in the rule table, k_c"] == ["1", "unit"]
        assert rows["limit of the adaptation, K₁"] == ["5.25", "unit/BLU"]
        assert rows["limit of the adaptation, K₂"] == ["3.5", "unit/BLU"]
        assert rows["limit of the adaptation"] == ["5.25", "3.5", "no"]
    # JK04 eq. 13: 32 units at 21 BLU; 16 at 14 and 8 at 7 are less
    assert rows["table, eq. 13 and 14"][0] == "1.524"
    assert (folder / "tables" / "rules.csv").exists()


def test_same_run_gives_the_same_bytes(report):
    arguments, page = report
    write_page(*arguments)
    assert (arguments[2] / "report.html").read_text() == page


def test_adapted_table_is_that_of_a_plain_transcription(report):
    scenario, result, _, _ = report[0]
    design, own = result.design, result.evaluation
    title = "What the adaptation made of it"
    titles = [section.title for section in sections(design, own, scenario)]
    if design.controller.kind == "flc":
        assert title not in titles
        return
    assert title in titles
    signals = {axis.name: axis.told() for axis in own.axes}
    found = at_the_end(design.controller, Shown(own.machine, scenario.plant.values(), signals))
    assert list(found) == ["X", "Y"]
    for axis, record in zip(own.axes, found.values(), strict=True):
        expected = feed_oracle.Adaptive(
            ERROR_TERMS,
            CHANGE_TERMS,
            rule_singletons("I"),
            (0.5, 0.125, 1.0),
            verdict_jk04,
            (5.25, 3.5),
        )
        for error in axis.reference - np.round(axis.motion.state.position):
            expected.step(error)
        assert expected.c != [list(row) for row in rule_singletons("I")]
        np.testing.assert_allclose(record.rules.centroids, expected.c, atol=1e-9)
        np.testing.assert_allclose(record.table().error_terms, expected.a, atol=1e-9)
        np.testing.assert_allclose(record.table().change_terms, expected.b, atol=1e-9)
    noisy = scenario.model_copy(update={"sensors": SensorSettings(noise=0.3)})
    assert title not in [section.title for section in sections(design, own, noisy)]
    lost = own._replace(diverged=True)
    assert title not in [section.title for section in sections(design, lost, scenario)]


def flc():
    return load_design("jee-koren-2004-flc").controller


def test_only_what_adapts_has_an_adapted_table():
    with pytest.raises(ValueError, match="kind flc does not adapt"):
        Controller(load_design("jee-koren-2004-flc")).adapted()
    design, scenario = load_design("pd-only"), load_scenario("c-axis-ramp")
    (section,) = sections(design, evaluate(design, scenario), scenario)
    assert section.listing.caption == "Gains of the kind pd."
    assert section.drawings == []


def written(figure):
    """(row, column) -> the number in that cell."""
    return {
        (round(text.get_position()[1]), round(text.get_position()[0])): text.get_text()
        for text in figure.axes[0].texts
    }


def test_heat_map_writes_the_table():
    table = np.array(rule_singletons("I"))
    table[1, 6] = -7.56
    changed = {"rules": flc().rules.model_copy(update={"centroids": table.tolist()})}
    figure = fuzzy_plots.rule_table(flc().model_copy(update=changed), "a title")
    cells = written(figure)
    assert len(cells) == 49
    assert cells[0, 0] == "\u221232.0"  # NL of e, NL of its change
    assert cells[1, 6] == "\u22127.6"
    assert cells[5, 0] == "8.0"
    for place, text in cells.items():
        assert float(text.replace("\u2212", "-")) == pytest.approx(table[place], abs=0.05)
    axes = figure.axes[0]
    for labels in (axes.get_xticklabels(), axes.get_yticklabels()):
        assert [label.get_text() for label in labels] == list(LABELS)
    assert axes.yaxis_inverted()
    shades = axes.collections[0].get_array()
    np.testing.assert_allclose(np.reshape(shades, (7, 7)), table)
    moved = fuzzy_plots.rule_table(flc().model_copy(update=changed), "", before=flc())
    assert written(moved) == cells
    shades = np.reshape(moved.axes[0].collections[0].get_array(), (7, 7))
    assert shades[1, 6] == pytest.approx(0.44)
    assert np.count_nonzero(shades) == 1


def test_terms_are_the_triangles_of_table_3():
    for axes, triangles in zip(
        fuzzy_plots.terms(flc(), "").axes, (ERROR_TERMS, CHANGE_TERMS), strict=True
    ):
        assert len(axes.lines) == 7
        for line, (left, centre, right) in zip(axes.lines, triangles, strict=True):
            x, y = line.get_data()
            assert x[1] == centre
            assert (x[0] == left and y[0] == 0) or (left == -INFINITY and y[0] == 1)
            assert (x[2] == right and y[2] == 0) or (right == INFINITY and y[2] == 1)
        assert [text.get_text() for text in axes.texts] == list(LABELS)
        assert "BLU" in axes.get_xlabel()
    assert len(fuzzy_plots.terms(flc(), "", before=flc()).axes[0].lines) == 14


def test_surface_is_what_the_rules_command():
    random = np.random.default_rng(1)
    record = flc()
    assert isinstance(record, FlcDesign)
    error, change = random.uniform(-25, 25, 50), random.uniform(-6, 6, 50)
    expected = [
        feed_oracle.output(ERROR_TERMS, CHANGE_TERMS, rule_singletons("I"), e, de)
        for e, de in zip(error, change, strict=True)
    ]
    np.testing.assert_allclose(fuzzy_plots.commanded(record, error, change), expected, atol=1e-9)
    axes = flat(fuzzy_plots.surface(record, "")).axes[0]
    assert axes.get_ylabel() == "error [BLU]"
    assert axes.get_ylim() == (-26.25, 26.25)  # 1.25 times 21 BLU
