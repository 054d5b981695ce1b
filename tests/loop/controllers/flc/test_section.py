"""The report of a run that designs a feed drive's fuzzy controller, and its pictures."""

import json
from types import SimpleNamespace

import feed_oracle
import numpy as np
import pytest
from click.testing import CliRunner
from imported_files import SHARED, SHARED_SIGNALS
from jk04 import CHANGE_TERMS, ERROR_TERMS, rule_singletons
from places import ROOT
from wording import refused, refused_command

from hfc_design.cli import main
from hfc_design.controllers.flc import section as fuzzy_plots
from hfc_design.controllers.flc.record import FlcDesign
from hfc_design.controllers.flc.rules import LABELS
from hfc_design.controllers.kind import ReportContext
from hfc_design.controllers.surfaces import flat
from hfc_design.files.design import design_json, parse_design
from hfc_design.files.loop_setup import load_design
from hfc_design.files.machine import PlantSettings
from hfc_design.files.named_scenario import load_scenario
from hfc_design.formats.reading import Wish, imported
from hfc_design.report.designs import picture
from hfc_design.report.parts import sections, summary
from hfc_design.runtime import Controller
from hfc_design.simulation.evaluating import Evaluation

INFINITY = float("inf")


def test_summary_compares_contour_errors():
    scenario = load_scenario("feed-drive-circle")

    def off(rms):
        metrics, contour = {"rms_contour_error_BLU": rms}, SimpleNamespace(unit="BLU")
        return Evaluation(1.0, 1.0, False, None, metrics, np.empty(0), (), contour)

    lost = off(None)._replace(diverged=True)
    published = {f"jee-koren-2004-{kind}": off(rms) for kind, rms in (("aflc", 1.0), ("flc", 5.0))}
    assert summary(scenario, off(2.0), published | {"jee-koren-2004-pid": lost}) == (
        "The controller reaches a contour error of 2 BLU rms on feed-drive-circle. For comparison: "
        "the AFLC of Jee & Koren (2004) 1 BLU, their FLC 5 BLU, their PID diverges there."
    )
    alone = "The controller reaches a contour error of 2 BLU rms on feed-drive-circle."
    assert summary(scenario, off(2.0), {}) == alone
    assert summary(scenario, off(2.0), published, yes=False) == alone
    other = load_scenario("feed-drive-circle", {"plant.axes.x.time_constant": 0.06})
    assert summary(other, off(2.0), published) == alone
    assert "diverges on feed-drive-circle" in summary(scenario, lost, published)


def flc():
    return load_design("jee-koren-2004-flc").controller


def test_only_what_adapts_has_an_adapted_table():
    with pytest.raises(ValueError, match="kind flc does not adapt"):
        Controller(load_design("jee-koren-2004-flc")).adapted()
    lost = Evaluation(1.0, 1.0, True, None, {}, np.empty(0), (), None)
    section, _ = sections(load_design("pd-only"), lost, load_scenario("c-axis-ramp"))
    assert section.listing.caption == "Gains of the kind pd."
    assert section.drawings == []


def cells_of(figure):
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
    cells = cells_of(figure)
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
    assert cells_of(moved) == cells
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


LESSON = ROOT / "docs" / "lesson.fll"


@pytest.fixture
def lesson():
    return imported(LESSON, Wish())


def command(design):
    """At an error of 20 BLU that does not change: rule P, Z alone."""
    controller = Controller(design)
    controller.step({"error": 20.0})
    return controller.step({"error": 20.0})


def test_a_rule_and_what_its_term_stands_for(lesson):
    assert command(lesson) == 60.0
    assert command(load_design(lesson, ["controller.rules.labels.2.1=forward"])) == 120.0
    assert command(load_design(lesson, ["controller.rules.output_terms.more=80"])) == 80.0


def test_a_new_term_that_a_rule_gets_at_once(lesson):
    changes = {"controller.rules.output_terms.big": 90, "controller.rules.labels.2.1": "big"}
    assert command(load_design(lesson, changes)) == 90.0


GAP, DRIFT = "gap (error)", "drift (change of error)"


@pytest.fixture(scope="module")
def design():
    return imported(SHARED["fll"], Wish(signals=SHARED_SIGNALS))


@pytest.fixture
def written(design, tmp_path):
    (tmp_path / "own.json").write_text(design_json(design))
    return tmp_path / "own.json"


@pytest.fixture
def explain(written):
    return lambda *arguments: CliRunner().invoke(main, ["explain", str(written), *arguments])


@pytest.mark.parametrize("what", ["surface", "surface-3d", "terms", "tables"])
def test_they_stand_on_pictures(design, what):
    axes = picture(design, what).axes
    told = " / ".join(f"{one.get_xlabel()} / {one.get_ylabel()}" for one in axes)
    assert GAP in told
    assert DRIFT in told


def test_they_stand_on_the_page(design):
    plant = PlantSettings(**design.plant.model_dump())
    sections = design.kind.sections(
        design.controller, ReportContext(plant.machine, plant.values(), signals=None)
    )
    assert "the error is called gap, its change drift" in sections[0].text
    assert any(GAP in drawing.alt for drawing in sections[0].drawings)


def test_explain_takes_them_like_the_signals(explain):
    own = explain("--json", "--at", "gap=2,drift=-0.5")
    assert own.exit_code == 0
    assert own.stdout == explain("--json", "--at", "error=2,error_change=-0.5").stdout
    told = json.loads(own.stdout)
    assert told["signals"] == {"error": 2.0, "error_change": -0.5}
    before = json.loads(explain("--json", "--at", "gap=2,previous_gap=2.5").stdout)
    assert before["units"] == told["units"]
    assert "gap (error)" in explain("--at", "gap=2,drift=-0.5").stdout


@pytest.mark.parametrize("at", ["gap=2,grift=1", "gap=2,error=1", "gap=2"])
def test_mistakes(written, at):
    refused_command("explain", written, "--at", at)


@pytest.mark.parametrize("change", ["labels.2.1=forwrd", "centroids.2.1=5", "output_terms.mroe=80"])
def test_what_cannot_be(lesson, change):
    with refused() as found:
        load_design(lesson, [f"controller.rules.{change}"])
    assert f"controller.rules.{change.partition('=')[0]}" in found.refusal


def test_a_mistyped_term_of_one_axis(lesson):
    own = lesson.controller.model_dump(mode="json")
    each = lesson.model_dump(mode="json") | {
        "controller": {"kind": "per-axis", "axes": {"x": own, "y": own}, "sample_time_s": 0.01}
    }
    whole, key = parse_design(json.dumps(each), "both"), "controller.axes.y.rules.output_terms.mroe"
    with refused() as found:
        load_design(whole, {key: 80})
    assert key in found.refusal


def test_the_file_itself_is_no_design_yet():
    with refused():
        load_design(LESSON)
