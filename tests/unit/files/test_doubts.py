"""What of a scenario is hardly meant: unit mistakes are told, and no scenario that is in order."""

import pytest

from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.plausibility import plausibility_warnings

#: A move of 60 mm that takes 60 / 150 + 150 / 1000 = 0.55 s.
MOVE = {
    "name": "move",
    "plant": {"name": "positioning-stage"},
    "simulation": {"duration_s": 1.5, "sample_time_s": 0.001},
    "controller": {"kind": "pid+ff"},
    "reference": {"kind": "trapezoidal", "distance": 60, "velocity": 150, "acceleration": 1000},
    "sensors": {"encoder_resolution": 0.001, "velocity": "observer", "observer_hz": 150.0},
    "fitness": {
        "kind": "tolerances",
        "settled_after_s": 0.9,
        "tolerances": {"rms_error": 0.01, "settled_rms_error": "10 um"},
    },
}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"simulation.sample_time_s": 0.05, "sensors.velocity": "tachometer"},
            ["30 samples; with fewer than 80 "],
        ),
        ({"simulation.sample_time_s": 0.01}, ["observer_hz = 150 [Hz]", "50 Hz"]),
        ({"sensors.observer_hz": 2000.0}, ["observer_hz = 2000 [Hz]", "500 Hz"]),
        ({"sensors.observer_hz": 501.0}, ["observer_hz = 501 [Hz]", "500 Hz"]),
        ({"fitness.settled_after_s": 1.5}, ["settled_after_s = 1.5 [s]"]),
        (
            {"simulation.duration_s": 0.3, "fitness.settled_after_s": 0.2},
            ["after 0.3 s of a move of 0.55 s"],
        ),
        # A uniform distribution of 40 um has a standard deviation of 40 / sqrt(12) um.
        ({"sensors.encoder_resolution": 0.04}, ["[mm]", "0.012 mm rms", "tolerances.rms_error"]),
        (
            {"sensors.encoder_resolution": 1.0, "fitness": {"kind": "lin-lee"}},
            ["encoder_resolution = 1 [mm]", "60 mm in total, only 60 such steps"],
        ),
    ],
)
def test_a_wrong_unit_is_doubted(changes, words):
    assert plausibility_warnings(load_scenario(MOVE)) == []
    (line,) = plausibility_warnings(load_scenario(MOVE, changes))
    for word in words:
        assert word in line


@pytest.mark.parametrize(
    "changes",
    [
        {"sensors.observer_hz": 500.0},
        {"sensors.observer_hz": 2000.0, "sensors.velocity": "tachometer"},  # is not read
        {"sensors.encoder_resolution": 0.03},
        {"simulation.duration_s": 0.55, "fitness.settled_after_s": 0.5},
        {"simulation.duration_s": 0.1, "fitness": {"kind": "lin-lee"}, "reference.distance": 0.5},
        {"reference.distance": 0.0},
    ],
)
def test_what_may_well_be_meant_is_not(changes):
    assert plausibility_warnings(load_scenario(MOVE, changes)) == []


def test_a_motion_is_named():
    motions = [{"name": "whole"}, {"name": "short", "duration_s": 0.4, "settled_after_s": 0.3}]
    (line,) = plausibility_warnings(load_scenario(MOVE, {"motions": motions}))
    assert line.startswith("move.short: the simulation ends after 0.4 s of a move of 0.55 s")
