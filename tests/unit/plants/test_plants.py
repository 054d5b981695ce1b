"""What plants say of themselves without a simulation: parameters, signals, and what is refused."""

import jax
import oracle
import pytest
from wording import refused

from hfc_design import api
from hfc_design.files.design import named_design
from plants import C_AXIS, PLANTS
from plants.blocks import once, ratio
from plants.c_axis import CAxisParameters, CAxisState, coefficients


def test_once_is_the_number_and_its_slope():
    assert jax.jvp(once, (3.0,), (0.5,)) == (3.0, 0.5)


def test_ratio_follows_the_quotient_rule():
    value, slope = jax.jvp(ratio, (3.0, 4.0), (0.5, -0.25))
    assert value == 0.75
    assert slope == pytest.approx((0.5 * 4.0 - 3.0 * -0.25) / 4.0**2)


def test_the_nominal_c_axis_and_its_signals_are_those_of_the_paper():
    assert CAxisParameters()._asdict() == oracle.MACHINE
    x = CAxisState(3.0, 0.5, 0.25, 0.125, 0.0625, 1e-5)
    found = C_AXIS.signals(coefficients(CAxisParameters(gear_ratio=2.0)), x)
    assert found["deflection"] == 0.5 - 2 * 0.125
    assert found["deflection_rate"] == 0.25 - 2 * 0.0625
    assert (found["spindle_velocity"], found["rotor_velocity"]) == (0.0625, 0.25)
    assert found["current"] == 3.0
    assert set(found) == set(C_AXIS.units) - {"error", "error_rate", "command", "load"}


def test_printed_gains_of_five_axes_are_a_speed_over_an_error():
    """Table 1: the largest error, 15 mm of X and 10 deg of A, asks for 8 V, the largest voltage."""
    machine, gains = PLANTS["five-axis"], named_design("lin-gai-2009-pid").controller.axes
    assert gains["x"].pid.k_p * 15.0 == pytest.approx(8.0, rel=2e-4)
    assert gains["a"].pid.k_p * 10.0 == pytest.approx(8.0, rel=2e-4)
    for axis, drive in zip(machine.axes, machine.drives, strict=True):
        per_volt = drive.parameters().velocity_per_volt
        wanted = (33.33 / per_volt, 0.1 / per_volt, 0.01 / per_volt)
        assert tuple(dict(gains[axis].pid).values()) == pytest.approx(wanted)


@pytest.mark.parametrize(
    ("plant", "name", "value"),
    [
        ("c-axis", "rotor_inertia", -1.0),
        ("c-axis", "inertia", 1.0),
        ("c-axis", "mutual_inductance", 0.33),
        ("c-axis", "static_torque", 0.6),
        ("positioning-stage", "mass", 0.0),
        ("positioning-stage", "viscous_asymmetry", 1.0),
    ],
)
def test_a_machine_that_is_impossible_is_refused_by_its_key(plant, name, value):
    with refused() as found:
        api.load_scenario({"plant": {"name": plant, "parameters": {name: value}}})
    assert f"plant.parameters.{name}" in found.refusal
