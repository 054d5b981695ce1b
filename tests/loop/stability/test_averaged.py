"""Cogging is no part of a linearised drive, which is that of the same drive without it."""

from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
import pytest
from along_a_line import along_a_line
from scipy.signal import cont2discrete
from shaken import shaken
from wording import refused

from hfc_design.stability.nominal import nominal
from plants import rk4

EVERY = 0.001  # [s]


class Parameters(NamedTuple):
    mass: float = 12.0  # [kg]
    drag: float = 50.0  # [N s/m]
    coulomb: float = 9.0  # [N]
    constant: float = 40.0  # [N/A]
    cogging: float = 0.0  # [N]
    pitch: float = 0.024  # [m]
    spring: float = 0.0  # [N/m]


class State(NamedTuple):
    place: Any
    speed: Any


def step(p, x, current, loads, dt):
    def rates(x, load):
        turn = 2.0 * jnp.pi * x.place / p.pitch
        cogging = p.cogging * (jnp.sin(turn) + 0.3 * jnp.cos(6.0 * turn)) + p.spring * x.place
        friction = p.drag * x.speed + p.coulomb * jnp.tanh(x.speed / 0.001)
        return State(x.speed, (p.constant * current - friction - cogging - load) / p.mass)

    return rk4(rates, x, loads, dt)


LINEAR_MOTOR = along_a_line("linear-motor", "A", Parameters, State, step)


@pytest.mark.parametrize("unit", [1.0, 30.0, 1000.0])
def test_a_linear_motor_is_that_without_its_cogging(unit):
    """Of whatever pitch: a unit of way may be a metre, a millimetre or a turn."""
    p = Parameters(cogging=30.0, pitch=0.024 * unit)
    found = nominal(LINEAR_MOTOR, p, EVERY)
    a, b = np.array([[0.0, 1.0], [0.0, -50.0 / 12.0]]), np.array([[0.0], [40.0 / 12.0]])
    a, b, *_ = cont2discrete((a, b, np.eye(2), np.zeros((2, 1))), EVERY)
    assert found.a == pytest.approx(a, abs=1e-9)
    assert found.b == pytest.approx(b[:, 0], rel=1e-9)
    assert found.velocity.command == pytest.approx(50.0 / 40.0, rel=1e-6)
    assert found.coulomb.command == pytest.approx(9.0 / 40.0, rel=1e-6)
    held = 0.5 * EVERY * 50.0  # [N s2/m] a command that is held lags half a sample behind the drag
    assert found.acceleration.command == pytest.approx((12.0 + held) / 40.0, rel=1e-6)
    assert found.load.command == pytest.approx(1.0 / 40.0, rel=1e-6)


class Geared(NamedTuple):
    angle: Any  # of the motor [rad]
    place: Any
    turning: Any
    speed: Any


class Gear(NamedTuple):
    cogging: float = 0.0  # [N m]
    lead: float = 0.005  # [m/rad]
    stiffness: float = 4e6  # [N/m]
    inertia: float = 1e-3  # of the motor [kg m2]


TWO = {"angle": "turning", "place": "speed"}


def turn(p, x, torque, loads, dt):
    def rates(x, load):
        force = p.stiffness * (p.lead * x.angle - x.place) + 3e3 * (p.lead * x.turning - x.speed)
        drive = torque - 0.01 * x.turning - p.cogging * jnp.sin(7.0 * x.angle) - p.lead * force
        return Geared(x.turning, x.speed, drive / p.inertia, (force - 30.0 * x.speed - load) / 40.0)

    return rk4(rates, x, loads, dt)


def test_behind_a_gear_the_motor_cogs_and_both_move_as_the_gear_has_it():
    drive = along_a_line("geared", "N m", Gear, Geared, turn, encoders=TWO)
    smooth, cogging = (nominal(drive, Gear(cogging=x), EVERY) for x in (0.0, 0.02))
    assert cogging.a == pytest.approx(smooth.a, rel=1e-4, abs=1e-6)
    assert cogging.b == pytest.approx(smooth.b, rel=1e-4)
    assert cogging.velocity.command == pytest.approx(DRAG, rel=1e-3)


#: By hand [N m s/m].
DRAG = (0.01 + 30.0 * 0.005**2) / 0.005


@pytest.mark.parametrize(("stiffness", "inertia"), [(4e6, 1e-5), (1e8, 1e-3), (2e8, 1e-3)])
def test_a_stiff_gear_moves_as_one(stiffness, inertia):
    """However small what drives it apart is beside what holds it together, in rad and m."""
    drive = along_a_line("geared", "N m", Gear, Geared, turn, encoders=TWO)
    found = nominal(drive, Gear(stiffness=stiffness, inertia=inertia), EVERY)
    assert found.velocity.command == pytest.approx(DRAG, rel=1e-6)
    mass = (inertia + 40.0 * 0.005**2) / 0.005  # a held command lags half a sample behind the drag
    assert found.acceleration.command == pytest.approx(mass + 0.5 * EVERY * DRAG, rel=1e-3)


def test_no_last_bit_decides_at_which_speed_a_stiff_drive_slides():
    """Steps from far away along the way are rounded, and Newton's method ends where that has it."""
    drive = along_a_line("geared", "N m", Gear, Geared, turn, encoders=TWO)
    first, *others = (nominal(drive, Gear(x), EVERY) for (x,) in shaken(0.05, times=3))
    for found in others:
        assert found.speed == first.speed
        np.testing.assert_allclose(found.a, first.a, rtol=1e-4, atol=1e-6)
        np.testing.assert_allclose(found.b, first.b, rtol=1e-4)


def test_a_spring_is_no_cogging():
    with refused() as found:
        nominal(LINEAR_MOTOR, Parameters(spring=100.0), EVERY)
    assert found.where == "the drive linear-motor cannot be linearised"
