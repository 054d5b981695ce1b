"""A feed drive of one axis: columns, metrics, pictures in its own units; whole commanded BLU."""

import csv
import io

import numpy as np
import pytest
from click.testing import CliRunner

from hfc_design.cli import main
from hfc_design.core.records import UserError
from hfc_design.files.machine import PlantSettings
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.pairing import load_design
from hfc_design.files.scenario import Scenario
from hfc_design.motion.references import Ramp
from hfc_design.motion.samples import Simulation
from hfc_design.simulation.evaluating import evaluate

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
COLUMNS = "time_s reference_BLU position_BLU error_BLU velocity_BLU_s command_unit load_unit"


@pytest.fixture(scope="module")
def scenario(tmp_path_factory):
    path = tmp_path_factory.mktemp("one-axis") / "one-axis.toml"
    path.write_text(SCENARIO)
    return path


def hfc(*arguments):
    done = CliRunner().invoke(main, [str(item) for item in arguments])
    assert done.exit_code == 0, done.output
    return done.stdout


@pytest.fixture(scope="module")
def evaluation(scenario):
    return evaluate(load_design("jee-koren-2004-pid"), load_scenario(str(scenario)))


def test_csv_has_the_units_of_the_drive(scenario):
    text = hfc("simulate", "jee-koren-2004-pid", "--scenario", scenario)
    header, *rows = csv.reader(io.StringIO(text))
    assert header == COLUMNS.split()
    time, reference, position, error, velocity, command, load = np.array(rows, float).T
    assert (reference == np.round(333.0 * time)).all()
    assert (command == np.round(command)).all()
    assert np.allclose(reference - position, error)
    assert velocity[-1] == pytest.approx(333.0, rel=0.3)
    assert (load == 1.0).all()


def test_metrics_are_named_in_the_units_of_the_drive(scenario, evaluation):
    text = hfc("score", "jee-koren-2004-pid", "--scenario", scenario)
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


def test_the_c_axis_design_does_not_fit(scenario):
    with pytest.raises(UserError, match="is for the plant c-axis"):
        evaluate(load_design("pd-only"), load_scenario(str(scenario)))
