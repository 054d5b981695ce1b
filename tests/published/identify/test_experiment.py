"""The experiment that is made: its intervals, its limits on other machines, its files."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from hfc_design import api
from hfc_design.cli import main
from hfc_design.identify.experiment import follower
from hfc_design.motion.gcode import blocks

LIMITS = {"travel": 250.0, "speed": 300.0, "acceleration": 3000.0}


@pytest.fixture(scope="module")
def made():
    return api.experiment("positioning-stage-move", **LIMITS)


def test_intervals_are_twice_as_narrow_as_those_of_the_scenarios_motion(made):
    """In the geometric mean of the parameters; the motion goes to and fro as long."""
    ratios = np.array([before / after for before, after in made.errors.values()])
    assert np.exp(np.log(ratios).mean()) > 2.0
    assert made.held == ("amplifier_gain",)


def test_no_limit_is_exceeded_by_machines_at_the_ends_of_the_tolerances(made, tmp_path):
    """Simulated as any scenario, with the experiment as its table."""
    table = tmp_path / "experiment.csv"
    rows = np.stack([made.time, made.reference], axis=1)
    np.savetxt(table, rows, delimiter=",")
    reference = {"kind": "csv", "file": str(table), "interpolation": "cubic"}
    design = follower(api.load_scenario("positioning-stage-move"))
    for mass, rub in ((0.8, 1.2), (1.2, 1.2), (1.2, 0.8)):
        changes = {
            "reference": reference,
            "simulation.duration_s": made.duration,
            "plant.parameters.mass": 95.11 * mass,
            "plant.parameters.coulomb_friction": 20.39 * rub,
            "plant.parameters.amplifier_gain": 35.1507 * 0.8,
        }
        (axis,) = api.evaluate(design, api.load_scenario("positioning-stage-move", changes)).axes
        place = np.asarray(axis.motion.state.position)
        assert np.ptp(place) <= LIMITS["travel"]
        assert np.abs(np.diff(place)).max() / made.sample_time <= LIMITS["speed"]
        assert np.abs(axis.motion.command).max() <= 10.0


def test_the_folder_has_what_controls_read(tmp_path):
    out = tmp_path / "out"
    call = ["experiment", "positioning-stage-move", "--add", "--duration", "8", "--out", str(out)]
    done = CliRunner().invoke(main, [*call, "--json"])
    assert done.exit_code == 0
    told = json.loads(done.output)
    assert any("added" in words for words in told["segments"])
    assert max(told["used"].values()) <= 1.0
    rows = np.loadtxt(out / "experiment.csv", delimiter=",", skiprows=1)
    streamed = np.loadtxt(out / "experiment.txt")
    np.testing.assert_allclose(rows[:, 1:], streamed, rtol=1e-6, atol=1e-9)
    assert f"#define EXPERIMENT_SAMPLES {len(rows)}" in (out / "experiment.h").read_text("utf-8")
    moves = blocks((out / "experiment.ngc").read_text("utf-8"))  # by the project's own reader
    assert max(one.end[0] for one in moves) == pytest.approx(rows[:, 1].max(), rel=0.02)
    page = (out / "report.html").read_text("utf-8")
    assert "Move the axis to the middle of its travel" in page


def test_a_travel_that_is_too_short_is_told_in_a_line():
    done = CliRunner().invoke(main, ["experiment", "positioning-stage-move", "--travel", "0.00001"])
    assert done.exit_code == 2
    assert "--travel 1e-05" in done.output
