"""A feed drive of one axis: columns, metrics, pictures in its own units; whole commanded BLU."""

from dataclasses import replace

import pytest

from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.pairing import load_design
from hfc_design.files.scenario import Scenario
from hfc_design.motion.samples import Simulation
from hfc_design.pictures.files import image
from hfc_design.report import plots
from hfc_design.report.errors import errors
from hfc_design.simulation.evaluating import evaluate
from hfc_design.simulation.evaluation import trajectory_csv

SCENARIO = """
[plant]
name = "feed-drive"

[reference]
kind = "ramp"
velocity = 333.0

[simulation]
duration_s = 0.5
sample_time_s = 0.01
substeps = 4

[load]
constant = 1.0

[controller]
inputs = [{ name = "error", scale = 0.05 }, { name = "velocity", scale = 0.0005 }]
"""


@pytest.fixture(scope="module")
def scenario(tmp_path_factory):
    path = tmp_path_factory.mktemp("one-axis") / "one-axis.toml"
    path.write_text(SCENARIO)
    return path


@pytest.fixture(scope="module")
def evaluation(scenario):
    return evaluate(load_design("jee-koren-2004-pid"), load_scenario(str(scenario)))


def test_pictures_are_labelled_in_the_units_of_the_drive(evaluation):
    drawing = image(plots.response(evaluation, "title"), "svg").decode()
    for label in ("position [BLU]", "error [BLU]", "command [unit]", "load [unit]", "axis"):
        assert f">{label}<" in drawing
    for label in ("rad]", "[V]", "deflection", "spindle"):
        assert label not in drawing
    assert "largest error [BLU]" in image(errors({"a": evaluation}), "svg").decode()


def test_the_spindle_is_told_where_it_should_be():
    axis = Scenario(name="x", simulation=Simulation(duration_s=0.01)).samples().axes[0]
    assert (axis.reference == axis.target).all()


def test_a_plant_of_a_user_has_its_own_units(evaluation):
    units = {"error": "mm", "error_rate": "mm/s", "command": "A", "load": "N"}
    (axis,) = evaluation.axes
    own = evaluation._replace(axes=(axis._replace(drive=replace(axis.drive, units=units)),))
    header = trajectory_csv(own).splitlines()[0].split(",")
    assert header[1] == "reference_mm"
    assert header[-3:] == ["velocity_mm_s", "current_A", "force_N"]
    drawing = image(plots.response(own, "title"), "svg").decode()
    for label in ("position [mm]", "error [mm]", "current [A]", "load [N]"):
        assert f">{label}<" in drawing
