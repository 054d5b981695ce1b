"""An axis of the milling table against SciPy, its energy, and what theory says of backlash."""

from functools import partial

import driven
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.optimize import fsolve
from two_bodies import Axis, reference

from plants.milling_table import (
    MILLING_TABLE,
    MillingTableParameters,
    MillingTableState,
    coefficients,
    step,
)

NOMINAL = MillingTableParameters()
#: On the flank that pushes forwards at 8 mm/s.
PUSHED = (0.0, 8.0, 0.2068, 8.0)


def path(p, start, voltages, dt=0.005, load=0.0):
    """(steps, 4) states."""
    return driven.path(MILLING_TABLE, p, start, voltages, dt, load)


CASES = {
    "across the gap into the flank": ((0.0, 0.0, 0.0, 0.0), 5.0, 0.0, 0.3),
    "pushed from rest": ((0.0, 0.0, 0.2, 0.0), 6.0, 0.0, 0.3),
    "to a stop on the flank": (PUSHED, 0.0, 0.0, 0.2),
    "back across the gap": (PUSHED, -6.0, 0.0, 0.3),
    "hardly away": ((0.0, 0.0, 0.2, 0.0), 2.3, 0.0, 0.5),
    "against a load": ((0.0, 0.0, -0.1, 0.0), 5.0, 200.0, 0.4),
    "stick-slip": ((0.0, 0.0, -0.1, 0.0), 4.0, 200.0, 0.4),
}


@pytest.mark.parametrize("case", CASES)
def test_motion_is_scipys(case):
    """Through impacts, stops and break-aways: within 1 um where a step of the scale is 5.

    Stick-slip makes 4 um of them, each break-away a little late.
    """
    start, voltage, load, seconds = CASES[case]
    times = 0.005 * np.arange(1, round(seconds / 0.005) + 1)
    wanted = reference(NOMINAL, start, voltage, load, times)
    found = path(NOMINAL, start, np.full(len(times), voltage), load=load)
    assert np.abs(found - wanted)[:, [0, 2]].max() < (5e-3 if case == "stick-slip" else 1e-3)
    finer = np.repeat(voltage, 4 * len(times))
    fine = path(NOMINAL, start, finer, 0.005 / 4, load)[3::4]
    errors = [np.abs(x - wanted)[:, [0, 2]].max() for x in (found, fine)]
    assert errors[1] < max(errors[0] / 2, 2e-5)  # and it converges


def test_a_table_at_rest_sticks_up_to_its_break_away_force():
    """400 N at the slides; the motor by its own friction, in the middle of the gap."""
    hold = 0.05 / 0.14  # [V] that the motor's friction bears
    for sign in (1.0, -1.0):
        still = path(NOMINAL, (3.0, 0.0, 3.0, 0.0), np.full(50, sign * hold * 0.999), 0.005, 399.9)
        np.testing.assert_array_equal(still, np.tile((3.0, 0.0, 3.0, 0.0), (50, 1)))
    away = path(NOMINAL, (3.0, 0.0, 3.0, 0.0), np.zeros(50), 0.005, -400.1)
    assert away[0, 1] > 0
    turns = path(NOMINAL, (3.0, 0.0, 3.0, 0.0), np.full(50, hold * 1.001))
    assert turns[0, 3] > 0


def test_the_table_waits_until_the_motor_has_crossed_the_backlash():
    """From one flank to the other the motor turns by 0.4 mm while the table stands."""
    for gap in (0.2, 0.4, 0.6):
        p = NOMINAL._replace(backlash=gap)
        found = path(p, (0.0, 0.0, 0.5 * gap, 0.0), np.full(150, -4.0), 0.001)
        position, _, motor, _ = found.T
        still = position == 0.0
        crossed = 0.5 * gap - motor[still].min()
        early = 0.0004 * np.abs(found[:, 3]).max()  # by which the damper touches before
        bends = 400.0 / NOMINAL.stiffness  # under the break-away force
        assert gap - early < crossed < gap + bends + 0.001
        assert (motor - position >= -0.5 * gap - 0.03).all()


def energy(axis, x):
    """Kinetic and elastic energy [N mm] of states (steps, 4)."""
    position, velocity, motor, motor_velocity = x.T
    off = motor - position
    bent = off - np.clip(off, -axis.gap / 2, axis.gap / 2)
    moving = axis.motor * motor_velocity**2 + axis.table * velocity**2
    return 0.5 * (moving + axis.stiffness * bent**2)


def test_energy_put_in_is_stored_or_lost():
    """In fine steps the losses of friction and damping make up the balance, and none is negative.

    In those of the control no sample gives back more than was put in.
    """
    random, axis = np.random.default_rng(2), Axis.of(NOMINAL)
    voltages = np.repeat(random.uniform(-8, 8, 40), 10)
    for fine in (1, 40):
        dt, pushed = 0.005 / fine, axis.gain * np.repeat(voltages, fine)
        x = np.vstack([np.zeros((1, 4)), path(NOMINAL, np.zeros(4), np.repeat(voltages, fine), dt)])
        put_in = pushed * np.diff(x[:, 2])
        lost = put_in - np.diff(energy(axis, x))
        assert lost.min() > -1e-9 * energy(axis, x).max()
    speed, motor = (0.5 * np.abs(x[1:, k] + x[:-1, k]) for k in (1, 3))
    slides = 300.0 + 100.0 * np.exp(-(speed**2)) + 5.0 * speed
    turning = axis.motor_friction + axis.motor_damping * motor
    mean = 0.5 * (x[1:] + x[:-1])
    off, rate = mean[:, 2] - mean[:, 0], mean[:, 3] - mean[:, 1]
    spring = [axis.spring(row) for row in mean]
    bent = axis.stiffness * (off - np.clip(off, -0.2, 0.2))
    damping = (spring - bent) * rate
    explained = dt * (slides * speed + turning * motor + damping).sum()
    assert lost.sum() == pytest.approx(explained, rel=2e-3)
    assert put_in.sum() == pytest.approx(explained + energy(axis, x)[-1], rel=2e-3)


#: A motor that hardly brakes before a table that weighs nothing and stays where it is left.
LOOSE = NOMINAL._replace(
    motor_friction=1e-9,
    motor_damping=0.006,
    coulomb_friction=2.0,
    stiction_rise=0.0,
    table_mass=0.1,
    viscous_friction=0.0,
)
SAMPLE = 0.001


def describing_function(amplitude, gap):
    """First harmonic of play's answer to ``amplitude sin``, by quadrature."""
    angle = np.linspace(0, 2 * np.pi, 4_000, endpoint=False)
    half, x = gap / 2, amplitude * np.sin(angle)
    rising = (angle <= np.pi / 2) | (angle >= 1.5 * np.pi)
    follows = np.maximum(x - half, half - amplitude), np.minimum(x + half, amplitude - half)
    return 2j * np.mean(np.where(rising, *follows) * np.exp(-1j * angle)) / amplitude


def predicted(gain):
    """Amplitude of the motor [mm] and frequency [rad/s] of the largest limit cycle, or None."""
    axis = Axis.of(LOOSE)

    def off(guess):
        amplitude, omega = guess
        s = 1j * omega
        motor = axis.gain / (s * (axis.motor * s + axis.motor_damping))
        loop = gain * motor * np.exp(-s * SAMPLE / 2) * describing_function(amplitude, 0.4)
        return (1 + loop).real, (1 + loop).imag

    found = []
    for guess in [(a, w) for a in (0.25, 0.5, 1.0, 2.0) for w in (3.0, 10.0, 30.0, 60.0)]:
        root, _, converged, _ = fsolve(off, guess, full_output=True)
        if converged == 1 and root[0] > 0.201 and root[1] > 0.1:
            found.append(tuple(root))
    return max(found, default=None)


def swinging(gain, start, seconds):
    """Table and motor in a loop with a proportional gain [V/mm] on the table's position."""
    x = MillingTableState(*map(jnp.float64, (start, 0.0, start, 0.0)))
    return map(np.array, _swinging(coefficients(LOOSE), x, gain, round(seconds / SAMPLE)))


@partial(jax.jit, static_argnums=3)
def _swinging(c, x, gain, steps):
    def body(x, _):
        after = step(c, x, -gain * x.position, (0.0, 0.0, 0.0), SAMPLE)
        return after, (after.position, after.motor_position)

    return jax.lax.scan(body, x, length=steps)[1]


@pytest.mark.parametrize(("gain", "within"), [(3.0, 0.07), (8.0, 0.035), (20.0, 0.02)])
def test_a_limit_cycle_is_where_the_describing_function_says(gain, within):
    """Its neglect of harmonics, and 2 N of friction, cost the less, the larger it swings."""
    amplitude, omega = predicted(gain)
    for start in (0.25, 3.0):  # from within and from without
        _, motor = swinging(gain, start, 6.0)
        late = motor[-3000:] - motor[-3000:].mean()
        ups = np.flatnonzero((late[:-1] < 0) & (late[1:] >= 0))
        assert np.ptp(late) / 2 == pytest.approx(amplitude, rel=within)
        assert 2 * np.pi / (np.diff(ups).mean() * SAMPLE) == pytest.approx(omega, rel=within / 2)


def test_sensors_count_and_the_command_is_bound():
    c = coefficients(NOMINAL)
    seen = MILLING_TABLE.measured(c, MillingTableState(0.0126, 1.3, -0.0009, 0.7))
    assert seen == pytest.approx((0.015, 1.3, -0.00125, 0.7))
    ideal = coefficients(NOMINAL._replace(scale_resolution=0.0))
    assert MILLING_TABLE.measured(ideal, seen._replace(position=0.0126)).position == 0.0126
    assert MILLING_TABLE.accepted(c, -12.0) == -10.0
