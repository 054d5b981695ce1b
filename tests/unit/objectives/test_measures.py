"""Measures that add up while a loop runs, against NumPy on its recorded motion."""

import numpy as np
import pytest
from wording import refused

from hfc_design.files.named_scenario import load_scenario
from hfc_design.objectives.measures import band_time, measure


def test_overshoot_on_a_program_is_beyond_every_reversal(tmp_path):
    """X turns round at 6 mm and ends at 0; before it does so, nothing is beyond."""
    (tmp_path / "there.ngc").write_text("G1 X6 F6000\nX0\n")
    limits = {axis: {"acceleration_per_s2": 800.0} for axis in "xyzac"}
    scenario = {
        "plant": {"name": "five-axis"},
        "reference": {"kind": "gcode", "file": str(tmp_path / "there.ngc"), "limits": limits},
        "simulation": {"duration_s": 0.5, "sample_time_s": 0.002},
        "controller": {"kind": "pid"},
    }
    x, y = load_scenario(scenario).samples().axes[:2]
    turn, stands = int(x.target.argmax()), x.target == 0.0
    assert not x.heading[:turn].any()
    assert x.end[turn:] == pytest.approx(np.where(stands[turn:], 0.0, 6.0), abs=1e-3)
    assert (x.heading[turn:] == np.where(stands[turn:], -1.0, 1.0)).all()
    assert not y.heading.any()  # it never moves


def test_a_band_is_a_program_once():
    assert measure("band_time", 1e-3) is measure("band_time", 1e-3)
    assert band_time(1e-3).meaning == "from then on the error stays within 0.001"
    with refused(ValueError) as found:
        measure("speed")
    assert found.where == "speed"
