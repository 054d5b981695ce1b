"""``hfc design --gains``: a controller by hand, judged as a search's design is."""

import json
from math import exp

import pytest
from run_folders import ran
from wording import refused_command

from hfc_design.calls.searching import with_gains

SCENE = ["--set", "simulation.duration_s=0.1"]
GAINS = "kp=38.995821,signals.velocity=-0.24345"  # of the cascade that comes with the package


def test_a_pid_by_hand_is_a_run_of_a_design_that_nobody_searched(tmp_path):
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
        ["--controller", "pid+ff", "--gains", "kp"],
        ["--controller", "pid+ff", "--gains", "kp=1,kx=2"],
        ["--controller", "pid+ff", "--gains", "kp=1,derivative_s=-1"],
    ],
    ids=range(4),
)
def test_gains_that_cannot_be_are_refused_and_leave_no_folder(options, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    refused_command("design", "positioning-stage-move", *options)
    assert not [*tmp_path.iterdir()]
