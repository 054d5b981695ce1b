"""A feed drive of one axis: columns, metrics, pictures in its own units; whole commanded BLU."""

import csv
import io
from dataclasses import replace

import numpy as np
import pytest
from one_axis import SCENARIO, printed
from wording import refused

from hfc_design.files.loop_setup import load_design
from hfc_design.files.machine import PlantSettings
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.scenario import Scenario
from hfc_design.motion.references import Ramp
from hfc_design.motion.samples import Simulation
from hfc_design.pictures.files import image
from hfc_design.report import plots
from hfc_design.report.errors import errors
from hfc_design.simulation.evaluating import evaluate, trajectory_csv

COLUMNS = "time_s reference_BLU position_BLU error_BLU velocity_BLU_s command_unit load_unit"


@pytest.fixture(scope="module")
def scenario(tmp_path_factory):
    path = tmp_path_factory.mktemp("one-axis") / "one-axis.toml"
    path.write_text(SCENARIO)
    return path


@pytest.fixture(scope="module")
def evaluation(scenario):
    return evaluate(load_design("jee-koren-2004-pid"), load_scenario(str(scenario)))


def test_csv_has_the_units_of_the_drive(scenario):
    text = printed("simulate", "jee-koren-2004-pid", "--scenario", scenario)
    header, *rows = csv.reader(io.StringIO(text))
    assert header == COLUMNS.split()
    time, reference, position, error, velocity, command, load = np.array(rows, float).T
    assert (reference == np.round(333.0 * time)).all()
    assert (command == np.round(command)).all()
    assert np.allclose(reference - position, error)
    assert velocity[-1] == pytest.approx(333.0, rel=0.3)
    assert (load == 1.0).all()


def test_metrics_are_named_in_the_units_of_the_drive(scenario, evaluation):
    text = printed("score", "jee-koren-2004-pid", "--scenario", scenario)
    assert "rms_error_BLU" in text
    assert "peak_command_unit" in text
    assert "rad" not in text
    error = evaluation.axes[0].motion.error
    assert evaluation.metrics["rms_error_BLU"] == pytest.approx(np.sqrt((error**2).mean()))


def test_the_control_is_told_whole_blu_and_judged_by_the_exact_path():
    samples = Scenario(
        name="x",
        plant=PlantSettings(name="feed-drive"),
        reference=Ramp(velocity=33.0),
        simulation=Simulation(duration_s=0.05, sample_time_s=0.01),
        controller={
            "inputs": [{"name": "error", "scale": 1.0}, {"name": "velocity", "scale": 1.0}]
        },
    ).samples()
    axis = samples.axes[0]
    assert axis.reference.tolist() == [0.0, 0.0, 1.0, 1.0, 1.0]  # of 0, 0.33, 0.66, 0.99, 1.32
    assert axis.target == pytest.approx([0.0, 0.33, 0.66, 0.99, 1.32])
    spindle = Scenario(name="x", simulation=Simulation(duration_s=0.01)).samples().axes[0]
    assert (spindle.reference == spindle.target).all()


def test_the_c_axis_design_does_not_fit(scenario):
    with refused() as found:
        evaluate(load_design("pd-only"), load_scenario(str(scenario)))
    assert found.where.startswith("design pd-only is for the plant c-axis")


def test_pictures_are_labelled_in_the_units_of_the_drive(evaluation):
    drawing = image(plots.response(evaluation, "title"), "svg").decode()
    for label in ("position [BLU]", "error [BLU]", "command [unit]", "load [unit]", "axis"):
        assert f">{label}<" in drawing
    for label in ("rad]", "[V]", "deflection", "spindle"):
        assert label not in drawing
    assert "largest error [BLU]" in image(errors({"a": evaluation}), "svg").decode()


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
