"""Servo axes of the five-axis machines against hand calculations and SciPy, and their coupling."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plants import PLANTS
from plants.five_axis import ServoState, acceleration, forces, step

MACHINE, COUPLED = PLANTS["five-axis"], PLANTS["five-axis-coupled"]
DRIVES = dict(zip(MACHINE.axes, MACHINE.drives, strict=True))
#: Of a unit of the position in SI.
SI = {"x": 1e-3, "a": np.pi / 180.0}


@jax.jit
def advance(c, x, volts, load, dt, count):
    return jax.lax.fori_loop(0, count, lambda _, x: step(c, x, volts, (load,) * 3, dt), x)


def after(axis, legs, count, start=(0.0, 0.0)):
    """Position and velocity after legs of (voltage, load, seconds) in ``count`` steps each."""
    drive = DRIVES[axis]
    c, x = drive.coefficients(drive.parameters()), ServoState(*map(jnp.float64, start))
    for volts, load, seconds in legs:
        x = advance(c, x, volts, load, seconds / count, count)
    return np.array(x)


def oracle(axis, legs):
    """The same by Radau in SI units, stopped where the velocity is 0: friction holds, or not."""
    p, unit = DRIVES[axis].parameters(), SI[axis]
    place, velocity = 0.0, 0.0
    for volts, load, seconds in legs:
        wanted, now = volts * p.velocity_per_volt * unit, 0.0

        def level(v, p=p, unit=unit):
            relative = v / (p.stribeck_velocity * unit)
            return p.coulomb_friction + p.stiction_rise * np.exp(-(relative**2))

        while now < seconds:
            pull = p.amplifier_gain * wanted - load
            if velocity == 0.0 and abs(pull) <= level(0.0):
                break  # it rests until the leg ends
            side = np.sign(pull) if velocity == 0.0 else np.sign(velocity)

            def rates(t, y, side=side, wanted=wanted, load=load, level=level):
                force = p.amplifier_gain * (wanted - y[1]) - load - p.viscous_friction * y[1]
                return [y[1], (force - side * level(y[1])) / p.inertia]

            def stops(t, y, side=side, now=now):
                return side * y[1] + (1e-9 if t == now else 0.0)

            stops.terminal, stops.direction = True, -1
            exact = {"method": "Radau", "rtol": 1e-10, "atol": 1e-13, "events": stops}
            found = solve_ivp(rates, (now, seconds), [place, velocity], **exact)
            place, velocity, now = found.y[0, -1], found.y[1, -1], found.t[-1]
            if found.status == 1:
                velocity = 0.0
    return np.array([place, velocity]) / unit


LEGS = {
    "x": [(0.06, 0.0, 0.05), (0.02, 40.0, 0.1), (-0.05, -30.0, 0.06), (0.0, 0.0, 0.05)],
    "a": [(0.05, 1.0, 0.04), (0.012, -2.0, 0.1), (-0.04, 0.0, 0.05), (0.0, 0.0, 0.05)],
}


@pytest.mark.parametrize("axis", LEGS)
def test_motion_with_stops_and_reversals_is_that_of_scipy(axis):
    """Of second order: a fourth of the error in half the step."""
    wanted = oracle(axis, LEGS[axis])
    errors = [abs(after(axis, LEGS[axis], count) - wanted)[0] for count in (100, 200, 400)]
    assert wanted[1] == 0.0  # friction has stopped it
    assert after(axis, LEGS[axis], 100)[1] == 0.0
    assert errors[0] < 2e-3 * abs(wanted[0]) + 1e-5
    assert errors[2] < 0.1 * errors[0]


def test_an_axis_sticks_up_to_its_break_away_level():
    """(150 + 60) N over 1.2e5 N s/m and 62.5 (mm/s)/V are 0.028 V."""
    assert after("x", [(0.02799, 0.0, 1.0)], 500).tolist() == [0.0, 0.0]
    moved = after("x", [(0.02801, 0.0, 1.0)], 500)
    assert moved[0] > 1e-4
    # with a load that helps it goes: 28 N are 0.0037 V
    assert after("x", [(0.0245, -28.0, 1.0)], 500)[0] > 0.01


@pytest.mark.parametrize("axis", ["x", "z", "c"])
def test_force_has_a_limit(axis):
    """At full voltage from rest the motor's peak pulls, friction of a fast slide holds against."""
    drive = DRIVES[axis]
    p, unit = drive.parameters(), 1e-3 if axis in "xyz" else np.pi / 180.0
    seconds, count = 0.04, 20  # steps of 2 ms
    place, velocity = after(axis, [(8.0, 0.0, seconds)], count)
    whole = (p.peak_force - p.coulomb_friction) / p.inertia / unit
    # a little less: viscous friction at half the speed, and Stribeck's at the start
    assert velocity == pytest.approx(whole * seconds, rel=0.03)
    assert place == pytest.approx(0.5 * whole * seconds**2, rel=0.04)
    assert velocity < whole * seconds


def test_energy_is_what_the_amplifier_gives_less_what_friction_takes():
    """Kinetic energy [J] against the integrals of power over steps of 10 us."""
    drive = DRIVES["x"]
    p, c = drive.parameters(), drive.coefficients(drive.parameters())
    wanted, dt = 0.4 * p.velocity_per_volt, 1e-5

    @jax.jit
    def run(x):
        def body(x, _):
            after = step(c, x, 0.4, (25.0,) * 3, dt)
            v = 0.5e-3 * (x.velocity + after.velocity)  # [m/s]
            rise = p.stiction_rise * jnp.exp(-((1e3 * v / p.stribeck_velocity) ** 2))
            force = p.amplifier_gain * (1e-3 * wanted - v)
            lost = 25.0 + p.coulomb_friction + rise + p.viscous_friction * v
            return after, jnp.array([force * v, lost * v]) * dt

        return jax.lax.scan(body, x, None, length=3000)

    end, power = run(ServoState(jnp.float64(0.0), jnp.float64(0.0)))
    given, lost = np.array(power).sum(axis=0)
    kinetic = 0.5 * p.inertia * (1e-3 * float(end.velocity)) ** 2
    assert kinetic > 0.1
    assert kinetic == pytest.approx(given - lost, rel=2e-5)


def test_speed_of_full_voltage_and_what_the_encoder_tells():
    for axis, rated in (("x", 500.0), ("z", 40e3 / 60.0), ("a", 20e3 / 60.0), ("c", 500.0)):
        drive = DRIVES[axis]
        p = drive.parameters()
        c, top = drive.coefficients(p), drive.top_speed(p)
        assert 0.98 * rated < top < rated
        x = ServoState(jnp.float64(0.0), jnp.float64(top))
        assert abs(acceleration(c, x, 8.0)) < 1e-6 * rated
        assert drive.accepted(c, 9.0) == 8.0
        assert drive.accepted(c, -8.5) == -8.0
        count = p.travel_per_turn / 16384
        seen = drive.measured(c, ServoState(7.4 * count, 0.0))
        assert float(seen.position) == pytest.approx(7 * count, rel=1e-12)


def coupling(commands=(0.0,) * 5, **places):
    """Loads that the coupled machine adds, at rest at these angles [deg]."""
    fixed = COUPLED.coefficients(tuple(drive.parameters() for drive in COUPLED.drives))
    states = tuple(ServoState(places.get(axis, 0.0), 0.0) for axis in COUPLED.axes)
    return np.array(forces(fixed, states, commands), dtype=float)


def test_slides_that_accelerate_turn_the_tables():
    """1,200 N less 210 N on 700 kg of X, 1,000 N less 170 N on 500 kg of Y."""
    x, y = 990.0 / 700.0, 830.0 / 500.0  # [m/s2]
    on_x = coupling((10.0 / 62.5, 0.0, 0.0, 0.0, 0.0), c=90.0)
    assert on_x[3:] == pytest.approx([0.0, -0.4 * x])
    on_y = coupling((0.0, 10.0 / (250 / 3), 0.0, 0.0, 0.0))
    assert on_y[3:] == pytest.approx([3.0 * y, 0.4 * y])
    # of a tilted table Y has less to say, gravity more
    tilted = coupling((0.0, 10.0 / (250 / 3), 0.0, 0.0, 0.0), a=60.0)
    across = 0.5 * y + np.sqrt(0.75) * 9.81
    assert tilted[3:] == pytest.approx([3.0 * across, 0.4 * across])


def test_z_sags_until_the_amplifier_holds_what_friction_does_not():
    """At rest the amplifier's force, 7e4 N s/m times a speed, is gravity's but for friction."""
    fixed = COUPLED.coefficients(tuple(drive.parameters() for drive in COUPLED.drives))
    gain = 33.33  # of a loop of the position [1/s]

    @jax.jit
    def run(states):
        def body(_, states):
            volts = tuple(
                -gain * x.position / c.velocity_per_volt for c, x in zip(fixed, states, strict=True)
            )
            loads = ((0.0,) * 3,) * 5
            return COUPLED.moved(fixed, states, volts, loads, 0.002, 1)

        return jax.lax.fori_loop(0, 1000, body, states)

    zero = tuple(ServoState(jnp.float64(0.0), jnp.float64(0.0)) for _ in COUPLED.axes)
    end = run(zero)
    held = -float(end[2].position) * gain * 70.0  # [N]
    assert abs(float(end[2].velocity)) < 1e-9
    assert 294.3 - 140.0 - 1e-6 < held < 294.3 + 140.0
    assert [float(x.position) for x in (end[0], end[1])] == [0.0, 0.0]
