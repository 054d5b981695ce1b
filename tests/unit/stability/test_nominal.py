"""Drives linearised while they slide: by hand, by SciPy, and what cannot be linearised."""

import pytest

from hfc_design.stability.nominal import nominal
from plants import C_AXIS


def test_the_c_axis_by_hand():
    """R = R_s + R_r L_s / L_r over K_t turns a torque into volts (LL eq. 1 at rest)."""
    p = C_AXIS.parameters()
    found = nominal(C_AXIS, p, 0.001)
    torque = p.mutual_inductance * p.rotor_flux / p.rotor_inductance  # [N m/A], 2 poles
    resistance = p.stator_resistance + p.rotor_resistance * p.stator_inductance / p.rotor_inductance
    volts = resistance / torque
    emf = p.stator_inductance * p.rotor_flux / p.mutual_inductance
    assert found.load.command == pytest.approx(volts)
    assert found.coulomb.command == pytest.approx(0.7 * volts)
    assert found.velocity.command == pytest.approx((2.05 + 0.4) * volts + emf)
    deflection = found.outputs["deflection"]
    assert deflection @ found.load.state == pytest.approx(1.0 / 200.0)
    assert deflection @ found.coulomb.state == pytest.approx(0.7 / 200.0)
    assert deflection @ found.velocity.state == pytest.approx(0.4 / 200.0)
    assert deflection @ found.acceleration.state == pytest.approx(5.102 / 200.0, rel=1e-3)
    assert found.speed > 10 * p.stribeck_velocity  # where friction no longer falls
