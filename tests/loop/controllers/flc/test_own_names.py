"""Names that a file gives its inputs and its output: on pictures, in explain, in a report."""

import json

import pytest
from click.testing import CliRunner
from imported_files import SHARED, SHARED_SIGNALS
from wording import refused_command

from hfc_design.cli import main
from hfc_design.controllers.kind import Shown
from hfc_design.files.design import design_json
from hfc_design.files.machine import PlantSettings
from hfc_design.formats.reading import Wish, imported
from hfc_design.report.designs import picture

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
