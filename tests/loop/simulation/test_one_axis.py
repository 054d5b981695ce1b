"""A feed drive of one axis: columns, metrics, pictures in its own units; whole commanded BLU."""

import csv
import io
import json
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
from hfc_design.plotting.files import image
from hfc_design.report import plots
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


def recorded(*arguments):
    """Columns of the trajectory that hfc simulate writes."""
    text = printed("simulate", *arguments)
    names = text.partition("\n")[0].split(",")
    return dict(zip(names, np.loadtxt(io.StringIO(text), delimiter=",", skiprows=1).T, strict=True))


def test_windows_of_an_axis():
    windows = 'windows=[{name="early", to_s=0.1}, {name="late", from_s=0.4}]'
    own = ("pd-only", "--set", "simulation.duration_s=0.5")
    found = json.loads(printed("score", *own, "--json", "--set", windows))
    motion = recorded(*own)
    for name, part in (("early", motion["time_s"] < 0.1), ("late", motion["time_s"] >= 0.4)):
        error = motion["error_rad"][part]
        assert found[f"{name}_rms_error_rad"] == pytest.approx(np.sqrt(np.mean(error**2)))
        assert found[f"{name}_max_error_rad"] == np.abs(error).max()
        assert found[f"{name}_iae_rad_s"] == pytest.approx(np.abs(error).sum() * 1e-3)
        assert found[f"{name}_final_error_rad"] == error[-1]
    assert found["late_rms_error_rad"] != found["rms_error_rad"]


def test_windows_of_a_path():
    short = ("simulation.duration_s=5", "reference.radius_mm=20")
    own = ("jee-koren-2004-flc", *(text for change in short for text in ("--set", change)))
    windows = 'windows=[{name="begin", to_s=1.0}, {name="middle", from_s=1.5, to_s=4.5}]'
    found = json.loads(printed("score", *own, "--json", "--set", windows))
    motion = recorded(*own)
    time = motion["time_s"]
    for name, part in (("begin", time < 1.0), ("middle", (time >= 1.5) & (time < 4.5))):
        off, change = motion["contour_error_BLU"][part], 0.0
        for axis in "xy":
            error, command = motion[f"{axis}_error_BLU"][part], motion[f"{axis}_command_unit"][part]
            assert found[f"{name}_{axis}_max_error_BLU"] == np.abs(error).max()
            change = max(change, np.sqrt(np.mean(np.diff(command) ** 2)))
        assert found[f"{name}_rms_contour_error_BLU"] == pytest.approx(np.sqrt(np.mean(off**2)))
        assert found[f"{name}_rms_command_change_unit"] == pytest.approx(change)
    # X reverses at the start only (t = 0), Y after a quarter of 10 s: in the middle
    assert found["begin_worst_glitch_BLU"] is None
    assert found["middle_worst_glitch_BLU"] is not None


def test_a_change_does_what_the_same_value_in_the_file_does(tmp_path):
    path = tmp_path / "mine.json"
    printed("export", "jee-koren-2004-flc", "--to", "json", "--out", path)
    data = json.loads(path.read_text())
    data["controller"]["integral_gain"] = 8.0
    path.write_text(json.dumps(data))
    own = ("--json", "--set", "simulation.duration_s=5")
    by_hand = json.loads(printed("score", path, *own))
    changed = json.loads(
        printed("score", "jee-koren-2004-flc", "--change", "controller.integral_gain=8", *own)
    )
    assert changed == by_hand
    assert changed != json.loads(printed("score", "jee-koren-2004-flc", *own))


def test_a_changed_design_says_so_and_loses_its_score():
    design = load_design("jee-koren-2004-aflc", {"controller.adaptation.k_c": 0.25})
    assert design.controller.adaptation.k_c == 0.25
    assert design.controller.adaptation.k_a == 0.5
    assert design.provenance["changes"] == {"controller.adaptation.k_c": 0.25}
    assert design.score == {}
