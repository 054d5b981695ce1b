"""A vertical axis of two masses, of a simulator that shares no code, by its log alone."""

import numpy as np
import pytest
from vertical import EVERY, GAIN, MOTOR, STEPS, STIFF, TABLE, WEIGHT, logged, reference

import hfc_design.api as hfc

TOLD = "position [m],reference [m],command [V],time [s]"


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    place, volts = logged()
    rows = np.stack([place, reference(), volts, EVERY * np.arange(STEPS)], axis=1)
    path = tmp_path_factory.mktemp("axis") / "log.csv"
    np.savetxt(path, rows, "%.9g", ",", header=TOLD, comments="")
    return path


def test_one_mass_finds_all_of_it_and_says_what_it_has_not(log):
    changes = {"plant.parameters.amplifier_gain": GAIN}
    found = hfc.identify(log, "positioning-stage", changes=changes)
    own, scenario = found.numbers()["parameters"], found.for_design()
    assert own["mass"]["value"] == pytest.approx(MOTOR + TABLE, rel=0.03)
    assert own["offset"]["value"] == pytest.approx(WEIGHT, rel=0.01)
    assert scenario.limits.delay_samples == pytest.approx(1.5, abs=0.2)
    assert scenario.sensors.encoder_resolution == pytest.approx(1e-3)
    asked = scenario.fitness.tolerances
    assert min(asked["rms_error"], asked["settled_rms_error"]) >= 1e-3
    swings = np.sqrt(STIFF * (1.0 / MOTOR + 1.0 / TABLE)) / (2.0 * np.pi)
    assert found.response.mode.hz == pytest.approx(swings, rel=0.15)
    assert f"there is a mode near {found.response.mode.hz:g} Hz" in " ".join(found.notes)


def test_two_masses_find_the_weight_as_a_load(log):
    sheet = ["motor_inertia=0.0035", "table_mass=220", "stiffness=1e5", "motor_friction=0.2"]
    sheet += ["coulomb_friction=80", "viscous_friction=0.4", "motor_damping=0.01", "load"]
    known = {"torque_gain": 2.5, "lead": 10.0, "backlash": 0.0, "stiction_rise": 0.0}
    changes = {f"plant.parameters.{name}": x for name, x in known.items()}
    found = hfc.identify(log, "milling-table", changes=changes, free=sheet)
    scenario = found.for_design()
    own = scenario.plant.parameters
    turn = 2.0 * np.pi / 0.01
    assert own["motor_inertia"] * turn**2 + own["table_mass"] == pytest.approx(1800.0, rel=0.03)
    assert scenario.load.constant == pytest.approx(WEIGHT, rel=0.01)
    late = scenario.limits.delay_samples + scenario.limits.lag_s / EVERY
    assert late == pytest.approx(1.5, abs=0.2)
    assert own["scale_resolution"] == pytest.approx(1e-3)
