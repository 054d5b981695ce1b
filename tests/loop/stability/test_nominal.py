"""Drives linearised while they slide: by hand, by SciPy, and what cannot be linearised."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from along_a_line import along_a_line
from scipy.signal import cont2discrete
from shaken import shaken
from wording import refused

from hfc_design.stability.nominal import _controllable, _Slides, nominal
from plants import C_AXIS, FEED_DRIVE, rk4
from plants.milling_table import MILLING_TABLE
from plants.positioning_stage import POSITIONING_STAGE


class Parameters(NamedTuple):
    mass: float = 5.0
    drag: float = 40.0
    coulomb: float = 0.0
    width: float = 0.01  # speed at which a smoothed friction is whole
    grip: float = 1.0  # share of the command that arrives


class State(NamedTuple):
    place: Any
    speed: Any


def step(p, x, force, loads, dt):
    def rates(x, load):
        friction = p.drag * x.speed + p.coulomb * jnp.tanh(x.speed / p.width)
        return State(x.speed, (p.grip * force - friction - load) / p.mass)

    return rk4(rates, x, loads, dt)


def sledge(step=step, **changes):
    return along_a_line("sledge", "N", Parameters, State, step, **changes)


SLEDGE = sledge()


@pytest.mark.parametrize("drag", [0.0, 40.0])
def test_a_linear_drive_is_its_own_model(drag):
    found = nominal(SLEDGE, Parameters(drag=drag), 0.01)
    continuous = (np.array([[0.0, 1.0], [0.0, -drag / 5.0]]), np.array([[0.0], [0.2]]))
    a, b, *_ = cont2discrete((*continuous, np.eye(2), 0), 0.01)
    np.testing.assert_allclose(found.a, a, atol=1e-12)
    np.testing.assert_allclose(found.b, b[:, 0], atol=1e-13)
    assert found.velocity.command == pytest.approx(drag, abs=1e-9)
    assert found.load.command == pytest.approx(1.0)
    assert found.coulomb.command == pytest.approx(0.0, abs=1e-6)
    np.testing.assert_array_equal(found.outputs["error_rate"], [0.0, -1.0])
    np.testing.assert_array_equal(found.outputs["speed"], [0.0, 1.0])


def test_the_inverse_model_follows_a_parabola_without_error():
    """Position a t^2 / 2 by commands that are held for a sample, from the states that it gives."""
    found = nominal(SLEDGE, Parameters(), 0.01)
    state = found.acceleration.state
    for k in range(200):
        velocity = 0.01 * k
        command = velocity * found.velocity.command + found.acceleration.command
        expected = 0.5 * velocity**2
        np.testing.assert_allclose(state[0], expected, atol=1e-9)
        state = found.a @ state + found.b * command


def test_the_feed_drive_by_hand():
    """u = V/K + F_c + start + slope V + curvature V^2; A of K/(s (tau s + 1)) with that slope."""
    p = FEED_DRIVE.parameters(gain=40.0, coulomb=3.0)
    found = nominal(FEED_DRIVE, p, 0.01, 400.0)
    slope = -1.16 * 0.01 + 2 * 0.05e-4 * 400.0
    friction = 3.0 + 6.54 - 1.16 * 4.0 + 0.05 * 16.0
    assert found.velocity.command == pytest.approx(1 / 40.0 + slope)
    assert found.coulomb.command == pytest.approx(friction - slope * 400.0)
    assert found.load.command == pytest.approx(1.0)
    # tau dv/dt = K (u - friction) - v; the mean of the friction at the ends of a step is held
    settled = np.exp(-(1.0 + 40.0 * slope) * 0.01 / 0.055)
    assert found.a[1, 1] == pytest.approx(settled, rel=1e-3)


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


@pytest.mark.parametrize("backlash", [0.0, 0.4])
def test_the_milling_table_by_hand_whatever_its_backlash(backlash):
    """The flanks touch while it slides: motor and table are one mass behind the screw."""
    p = MILLING_TABLE.parameters(backlash=backlash)
    turn = 2.0 * np.pi / 5.0  # [rad/mm]
    force = 1e3 * 0.14 * turn  # [N/V]
    damping = 1e3 * 0.06 * turn**2 + 5.0
    model = nominal(MILLING_TABLE, p, 0.005)
    assert 2.0 < model.speed < 10.0  # of 363 N and 100 N s/mm
    share = model.speed / p.stribeck_velocity  # there friction still falls by this much
    falls = 2.0 * p.stiction_rise * share / p.stribeck_velocity * np.exp(-(share**2))
    assert model.velocity.command == pytest.approx((damping - falls) / force, rel=1e-6)
    assert model.coulomb.command == pytest.approx((300.0 + 50.0 * turn) / force, rel=1e-3)
    # A sample's command acts half a sample late.
    mass = 1e3 * 8e-4 * turn**2 + 0.1
    assert model.acceleration.command == pytest.approx(
        mass / force + 0.0025 * damping / force, rel=0.01
    )
    assert nominal(MILLING_TABLE, p, 0.005, 1.0).speed == 1.0


def test_the_positioning_stage_by_hand():
    """Forwards: u g = mass a + F_v v + F_c + offset + load; a command acts half a sample late."""
    p = POSITIONING_STAGE.parameters()
    found = nominal(POSITIONING_STAGE, p, 1e-3)
    assert found.speed > 1e3 * (20.39 - 3.16) / 203.5  # where the viscous friction is the larger
    volt, drag = 35.1507, 0.2035 / 35.1507
    assert found.velocity.command == pytest.approx(drag, rel=1e-6)
    assert found.acceleration.command == pytest.approx(0.09511 / volt + 0.0005 * drag, rel=1e-3)
    assert found.coulomb.command == pytest.approx((20.39 - 3.16) / volt, rel=1e-6)
    assert found.load.command == pytest.approx(1.0 / volt, rel=1e-6)
    assert found.a[1, 1] == pytest.approx(np.exp(-0.2035 / 95.11), rel=1e-9)


@pytest.mark.parametrize("width", [1e-4, 0.01])
def test_the_speed_is_one_at_which_friction_slides(width):
    """Viscous and Coulomb parts are alike at 20 / 40 = 0.5 m/s, whatever smooths the step."""
    p = Parameters(coulomb=20.0, width=width)
    found = nominal(SLEDGE, p, 0.001)
    assert found.speed == pytest.approx(0.5, rel=1e-6)
    assert found.velocity.command == pytest.approx(40.0)
    assert found.coulomb.command == pytest.approx(20.0)


class Geared(NamedTuple):
    angle: Any
    speed: Any
    heat: Any


def warming(p, x, force, loads, dt):
    moved = step(p, State(x.angle, x.speed), force, loads, dt)
    return Geared(*moved, 1.1 * x.heat + 0.0 * force)


@pytest.mark.parametrize(
    ("drive", "parameters"),
    [
        pytest.param(SLEDGE, Parameters(grip=0.0), id="no command arrives"),
        pytest.param(
            sledge(step=lambda p, x, u, loads, dt: State(x.place * jnp.nan, x.speed)),
            Parameters(),
            id="no number",
        ),
        pytest.param(
            sledge(
                step=warming,
                initial_state=lambda zero: Geared(zero, zero, zero),
                position="angle",
                encoders={"angle": "speed"},
            ),
            Parameters(),
            id="heat that grows",
        ),
    ],
)
def test_what_cannot_be_linearised_is_told_in_a_line(drive, parameters):
    with refused() as found:
        nominal(drive, parameters, 0.01)
    assert found.where == "the drive sledge cannot be linearised"


def test_a_flank_that_hardly_anything_presses_on_is_closed():
    """With a thousandth of a newton of friction on the table, a gap changes nothing."""
    table = MILLING_TABLE
    own = {"coulomb_friction": 1e-3, "viscous_friction": 1e-3, "stiction_rise": 0.0}
    gap, none = (nominal(table, table.parameters(backlash=x, **own), 0.001) for x in (0.3, 0.0))
    assert gap.speed == pytest.approx(none.speed, rel=1e-6)
    np.testing.assert_allclose(gap.a, none.a, rtol=1e-6)
    assert gap.coulomb.command == pytest.approx(none.coulomb.command, rel=1e-6)
    backwards = nominal(table, table.parameters(backlash=0.4), 0.005, -3.0)
    forwards = nominal(table, table.parameters(backlash=0.4), 0.005, 3.0)
    assert backwards.coulomb.command == pytest.approx(-forwards.coulomb.command, rel=1e-6)


def test_a_speed_at_which_nothing_is_steady_is_refused():
    with refused() as found:
        nominal(C_AXIS, C_AXIS.parameters(), 0.001, 1e200)
    assert found.where == "the drive c-axis cannot be linearised"


def test_no_last_bit_decides_at_which_of_two_speeds_both_parts_are_alike():
    """40 N of either at 1 m/s, which is one of the speeds that are tried."""
    for drag, coulomb in shaken(40.0, 40.0):
        found = nominal(SLEDGE, Parameters(drag=drag, coulomb=coulomb), 0.001)
        assert found.speed == pytest.approx(1.0, rel=1e-8)


@pytest.mark.parametrize("speed", [1e6, 1e3, 1.0])
def test_whatever_the_speed_the_whole_axis_is_shifted(speed):
    """At 1e6 rad/s the bristles are 1e11 times as stiff as anything else."""
    with jax.enable_x64(True):
        found = _Slides(C_AXIS, C_AXIS.parameters(), np.zeros((1, 6))).motion(1e-3, speed)
    whole = [0.0, 1.0, 0.0, 1.0, 0.0, 0.0]  # rotor and spindle, by the same angle
    np.testing.assert_allclose(found.near.along[0, :, 0], whole, atol=1e-9)


@pytest.mark.parametrize("driven", [False, True])
def test_what_the_command_moves_does_not_depend_on_units_or_last_bits(driven):
    """Two sledges in a row, or one that is free: in metres and micrometres, or sums of them."""
    rng = np.random.default_rng(3)
    a, b = np.eye(4), np.array([0.0, 0.0, 0.0, 1.0])
    a[0, 1] = a[2, 3] = 0.01
    a[1, 2] = 0.01 * driven
    turns = [np.diag([1.0, 1.0, size, size]) for size in (1e-6, 1e-3, 1e3, 1e6)]
    for turn in (*turns, *rng.standard_normal((20, 4, 4))):
        assert _controllable(turn @ a @ np.linalg.inv(turn), turn @ b) == driven
