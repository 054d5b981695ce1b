"""Circular tests of simulated machines: causes are those that the machine was given."""

import json
from math import pi

import pytest

import hfc_design.api as hfc

GAINS = {"x": 28.0, "y": 35.0}  # [V/mm]
GAP, FEED = 0.05, 300.0  # backlash of Y [mm], feed [mm/min]


@pytest.fixture(scope="module")
def tested(tmp_path_factory):
    """A table with P controllers on the encoders at its motors, and with hardly any friction."""
    pids = {x: {"kind": "pid", "pid": {"k_p": k, "k_i": 0.0, "k_d": 0.0}} for x, k in GAINS.items()}
    path = tmp_path_factory.mktemp("circle") / "soft-x.json"
    text = {
        "format": "hfc-design",
        "version": 1,
        "name": "soft-x",
        "plant": {"name": "milling-table", "parameters": {}},
        "controller": {"kind": "per-axis", "sample_time_s": 0.005, "axes": pids},
        "limits": {"command": 10.0},
    }
    path.write_text(json.dumps(text))
    axis = {"coulomb_friction": 1.0, "stiction_rise": 0.0, "motor_friction": 0.0, "backlash": 0.0}
    changes = {
        "reference.radius_mm": 10.0,
        "reference.feed_mm_min": FEED,
        "plant.axes.x": axis,
        "plant.axes.y": axis | {"backlash": GAP},
        "sensors.feedback": "motor_position",
    }
    scenario = hfc.load_scenario("milling-table-circle", changes)
    return hfc.circle(path, scenario), path, scenario


def test_backlash_is_named_with_its_size(tested):
    result, _, _ = tested
    assert result.causes[0].name == "backlash of Y"
    assert result.causes[0].size == pytest.approx(GAP, rel=0.1)


def test_gains_that_differ_are_a_servo_mismatch_of_their_lags(tested):
    """A P loop lags by damping / (force gain k_p): what the motor and the slides damp, per volt."""
    turn = 2 * pi / 5.0  # [rad/mm] of the screw
    damping, force = 1e3 * 0.06 * turn**2 + 5.0, 1e3 * 0.14 * turn  # [N s/mm], [N/V]
    lag = damping / force * (1 / GAINS["x"] - 1 / GAINS["y"])  # [s]
    result, _, _ = tested
    found = next(one for one in result.causes if one.name == "servo mismatch")
    assert found.value == pytest.approx(FEED / 60.0 * lag, rel=0.1)
    assert result.feed == pytest.approx(FEED, rel=1e-3)


def test_metrics_are_those_of_the_full_turns(tested):
    result, path, scenario = tested
    both = {"reference.direction": "both", "reference.cycles": 2.0, "simulation.duration_s": 52.0}
    found = hfc.evaluate(path, hfc.load_scenario(scenario, both)).metrics
    known = result.deviations
    largest = max(known["G(XY)"], known["G(YX)"])
    assert found["circular_deviation_mm"] == pytest.approx(largest, rel=1e-3)
    assert found["bidirectional_circular_deviation_mm"] == pytest.approx(known["G(b)"], rel=1e-3)
    farthest = max(abs(x) for key, x in known.items() if key[0] == "F")
    assert found["radial_deviation_mm"] == pytest.approx(farthest, rel=1e-3)
    for key, change in (("circular", {}), ("radial", {"reference.cycles": 0.5})):
        metrics = hfc.evaluate(path, hfc.load_scenario(scenario, change)).metrics
        assert (f"{key}_deviation_mm" in metrics) == (not change)
        assert "bidirectional_circular_deviation_mm" not in metrics
