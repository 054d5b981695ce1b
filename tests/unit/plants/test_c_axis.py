"""The C-axis against its equations, against SciPy and against physics."""

import oracle
import pytest

from hfc_design.files.machine import PlantSettings
from plants import C_AXIS
from plants.c_axis import CAxisParameters, CAxisState, coefficients


def test_nominal_machine_is_the_one_of_the_paper():
    assert CAxisParameters()._asdict() == oracle.MACHINE


def test_signals_are_those_of_the_paper():
    x = CAxisState(3.0, 0.5, 0.25, 0.125, 0.0625, 1e-5)
    found = C_AXIS.signals(coefficients(CAxisParameters(gear_ratio=2.0)), x)
    assert found["deflection"] == 0.5 - 2 * 0.125
    assert found["deflection_rate"] == 0.25 - 2 * 0.0625
    assert (found["spindle_velocity"], found["rotor_velocity"]) == (0.0625, 0.25)
    assert found["current"] == 3.0
    assert set(found) == set(C_AXIS.units) - {"error", "error_rate", "command", "load"}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"rotor_inertia": -1.0}, "parameters.rotor_inertia = -1.0: has to be more than zero"),
        ({"stiffness": 0.0}, "parameters.stiffness = 0.0: has to be more than zero"),
        ({"viscous_friction": -0.1}, "parameters.viscous_friction = -0.1: has to be zero or more"),
        ({"inertia": 1.0}, "parameters.inertia: unknown; did you mean rotor_inertia?"),
        ({"x": 1.0}, "parameters.x: unknown; there is poles, rotor_flux, stator_"),
        ({"mutual_inductance": 0.33}, "parameters.mutual_inductance = 0.33: its square has to"),
        ({"static_torque": 0.6}, "static_torque = 0.6: has to be at least coulomb_torque = 0.7"),
    ],
)
def test_impossible_machine_is_named(changes, message):
    assert message in C_AXIS.fault(changes)
    with pytest.raises(ValueError, match="parameters"):
        PlantSettings(parameters=changes)


def test_possible_machine_has_no_fault():
    assert C_AXIS.fault({}) is None
    assert C_AXIS.fault({"rotor_damping": 0.0, "static_torque": 0.7}) is None
