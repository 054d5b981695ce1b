"""The command line as a user meets it."""

import csv
import io
import json
import re
import signal
import subprocess
import sys
from contextlib import suppress
from math import exp

import numpy as np
import pytest
from run_folders import hfc, ran
from wording import refused_command

from hfc_design.calls.searching import with_gains
from hfc_design.cli import search_progress
from hfc_design.files.design import design_json
from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.simulation.evaluating import evaluate

SHORT = ["--set", "simulation.duration_s=0.1"]
SMALL = ["--population", "4", "--generations", "3", "--set", "controller.kind=pd", *SHORT]


def test_score_of_the_published_design_is_the_published_one():
    done = hfc("score", "lin-lee-1999-table-1", "--json")
    assert done.exit_code == 0
    found = json.loads(done.stdout)
    assert found["fitness"] == pytest.approx(380.5715, abs=5e-5)
    assert found["scenario"] == "c-axis-ramp"
    assert found["stick_events"] == 0


def test_diverged_design_is_a_result(tmp_path):
    path = tmp_path / "wild.json"
    path.write_text(design_json(load_design("pd-only", {"controller.pd.kd": 1e9})))
    done = hfc("score", path, "--json", *SHORT)
    assert done.exit_code == 0
    found = json.loads(done.stdout)
    assert found["diverged"] is True
    assert found["fitness"] is None
    assert found["merit"] is None
    assert found["rms_error_rad"] is None
    assert "diverged" in hfc("score", path, *SHORT).stdout


def test_a_motion_is_written_with_the_agreed_header_and_a_row_a_sample(tmp_path):
    short = ("simulate", "pd-only", *SHORT)
    done = hfc(*short, "--csv", tmp_path / "a.csv", "--plot", tmp_path / "a.png")
    assert done.exit_code == 0
    assert done.stdout.split() == [str(tmp_path / "a.csv"), str(tmp_path / "a.png")]
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    rows = list(csv.reader(io.StringIO(hfc(*short).stdout)))
    assert rows == list(csv.reader((tmp_path / "a.csv").read_text().splitlines()))
    assert ",".join(rows[0]) == (
        "time_s,reference_rad,spindle_angle_rad,error_rad,spindle_velocity_rad_s,"
        "deflection_rad,voltage_V,load_torque_Nm"
    )
    data = np.array(rows[1:], float)
    assert data.shape == (100, 8)
    assert np.allclose(data[:, 1] - data[:, 2], data[:, 3], atol=1e-15)
    assert np.allclose(data[:, 0], np.arange(100) * 0.001)


def _interrupted(self, search):
    raise KeyboardInterrupt


def test_interrupted_design_says_how_to_go_on(tmp_path, monkeypatch):
    monkeypatch.setattr(search_progress.Watch, "generation", _interrupted)
    done = hfc("design", "c-axis-ramp", *SMALL, "--out", tmp_path / "run")
    assert done.exit_code == 1
    assert f"hfc design --resume --out {tmp_path / 'run'}" in done.stderr
    assert (tmp_path / "run" / "checkpoint.npz").exists()
    for command in ("score", "simulate", "export --to c"):
        refused = refused_command(*command.split(), tmp_path / "run")
        assert refused.where == str(tmp_path / "run")


def test_an_interrupt_that_a_library_has_ignored_is_heard_after_the_generation(
    tmp_path, monkeypatch
):
    def ignored(self, search):
        with suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(search_progress.Watch, "generation", ignored)
    done = hfc("design", "c-axis-ramp", *SMALL, "--out", tmp_path / "run")
    assert done.exit_code == 1
    assert "interrupted" in done.stderr
    assert len((tmp_path / "run" / "history.csv").read_text().splitlines()) == 3


def test_an_interrupt_that_nobody_could_hear_is_not_told_as_a_fault():
    """As in what a garbage collector calls; other faults there are told."""
    code = """
from hfc_design.core.interrupt import listen
class Gone:
    def __init__(self, fault): self.fault = fault
    def __del__(self): raise self.fault
listen()
Gone(KeyboardInterrupt())
Gone(ValueError("told"))
"""
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "KeyboardInterrupt" not in ended.stderr
    assert "ValueError: told" in ended.stderr


SCENE = ["--set", "simulation.duration_s=0.1"]
GAINS = "kp=38.995821,signals.velocity=-0.24345"  # of the cascade that comes with the package


def test_a_pid_by_hand_is_a_run_of_a_design_that_nobody_searched(tmp_path, known_use):
    by_hand = ["--controller", "pid+ff", "--gains", GAINS, *SCENE]
    said = ran("design", "positioning-stage-move", *by_hand, "--out", tmp_path / "hand")
    assert "Can I use it?" in said
    found = json.loads((tmp_path / "hand" / "design.json").read_text())
    built_in = json.loads(ran("score", "emps-cascade", *SCENE, "--json"))
    assert found["score"]["rms_error_mm"] == pytest.approx(built_in["rms_error_mm"])
    assert not (tmp_path / "hand" / "history.csv").exists()


def test_its_velocity_filter_is_told_by_its_frequency_or_its_time_constant():
    """A lag of the first order keeps exp(-T / tau) of its state in a sample."""
    design = with_gains("positioning-stage-move", "pid+ff", {"kp": 1.0, "derivative_s": 0.002})
    assert design.controller.filter_pole == pytest.approx(exp(-0.001 / 0.002))
    assert design.controller.derivative_hz == pytest.approx(79.577, abs=1e-3)


@pytest.mark.parametrize(
    "options",
    [
        ["--gains", "kp=1"],
        ["--controller", "pid+ff", "--gains", "kp=1,kx=2"],
        ["--controller", "pid+ff", "--gains", "kp=1,derivative_s=-1"],
    ],
    ids=range(3),
)
def test_gains_that_cannot_be_are_refused_and_leave_no_folder(options, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    refused_command("design", "positioning-stage-move", *options)
    assert not [*tmp_path.iterdir()]


MOTIONS = """
[simulation]
duration_s = 0.1
[fitness]
settled_after_s = 0.06
[[motions]]
name = "ramp"
[[motions]]
name = "creep"
reference = { kind = "ramp", velocity = 0.002 }
duration_s = 0.08
"""


@pytest.fixture
def two(tmp_path):
    """A scenario of two motions without tolerances."""
    (tmp_path / "two.toml").write_text(MOTIONS)
    return tmp_path / "two.toml"


def test_one_motion_of_several_is_simulated(two, tmp_path):
    done = hfc("simulate", "pd-only", "--scenario", two, "--motion", "creep")
    assert done.exit_code == 0, done.output
    names, *rows = done.stdout.splitlines()
    columns = dict(
        zip(names.split(","), np.array([r.split(",") for r in rows], float).T, strict=True)
    )
    scenario = load_scenario(str(two))
    (axis,) = evaluate("pd-only", scenario).motions["creep"].axes
    np.testing.assert_array_equal(columns["error_rad"], axis.motion.error)
    assert columns["reference_rad"][-1] == pytest.approx(0.002 * 0.079)
    first = hfc("simulate", "pd-only", "--scenario", two).stdout
    assert first == hfc("simulate", "pd-only", "--scenario", two, "--motion", "ramp").stdout
    assert first != done.stdout
    drawn = ["--motion", "creep", "--plot", tmp_path / "c.png"]
    assert hfc("simulate", "pd-only", "--scenario", two, *drawn).exit_code == 0
    assert (tmp_path / "c.png").read_bytes().startswith(b"\x89PNG")
    scored = hfc("score", "pd-only", "--scenario", two, "--motion", "creep", "--json").stdout
    assert json.loads(scored)["max_error_rad"] == max(abs(columns["error_rad"]))
    for name, scene in (("crawl", two), ("creep", "c-axis-ramp")):
        lost = refused_command("simulate", "pd-only", "--scenario", scene, "--motion", name)
        assert lost.where == f"--motion {name}"


def test_a_loop_that_is_off_again_and_again_settles_never():
    """The error of a PD follows the acceleration of a sine to the last sample."""
    done = hfc(
        "score", "pd-only", "--scenario", "c-axis-sine", "--set", "simulation.duration_s=0.2"
    )
    assert re.search(r"settling_time_s +never\n", done.stdout), done.output
