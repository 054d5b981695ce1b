"""Labels and output terms of an imported table, changed by their keys."""

import json

import pytest
from click.testing import CliRunner
from imported_files import SHARED, SHARED_SIGNALS
from places import ROOT
from wording import refused, refused_command

from hfc_design.cli import main
from hfc_design.controllers.kind import Shown
from hfc_design.files.design import design_json, parse_design
from hfc_design.files.machine import PlantSettings
from hfc_design.files.pairing import load_design
from hfc_design.formats.reading import Wish, imported
from hfc_design.report.designs import picture
from hfc_design.runtime import Controller

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
        design.controller, Shown(plant.machine, plant.values(), signals=None)
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
