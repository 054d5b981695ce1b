"""Friction and motion of the feed drive against hand calculations and SciPy."""

import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from feed_oracle import output
from jk04 import CHANGE_TERMS, ERROR_TERMS, PARAMETER_SETS, rule_singletons, without_friction
from scipy.integrate import solve_ivp
from wording import refused

from hfc_design import api
from plants import FEED_DRIVE
from plants.feed_drive import (
    FeedDriveParameters,
    FeedDriveState,
    accepted,
    coefficients,
    friction,
    step,
)

FREE = (0.0, 0.0, 0.0)
TAU = 0.055
START = {"x": (6.54, 6.43), "y": (7.23, 5.04)}  # JK04 eq. 28 at V -> 0, forwards and backwards


def printed_friction(axis, v):
    """Coulomb level 15 and JK04 eq. 28, in ``v`` [mm/s]."""
    if abs(v) >= 12:
        return math.copysign(15.0, v)
    if axis == "x":
        low = 0.05 * v**2 - 1.16 * v + 6.54 if v >= 0 else -0.04 * v**2 - 1.00 * v - 6.43
    else:
        low = 0.04 * v**2 - 1.12 * v + 7.23 if v >= 0 else -0.02 * v**2 - 0.68 * v - 5.04
    return math.copysign(15.0, v) + low


@jax.jit
def advance(c, x, command, load, dt, count):
    """The state after ``count`` steps of ``dt`` under constant command and load."""
    loads = (load, load, load)
    return jax.lax.fori_loop(0, count, lambda _, x: step(c, x, command, loads, dt), x)


def after(p, start, command, seconds, count, load=0.0):
    """Position and velocity after ``count`` equal steps, from ``start``."""
    x = FeedDriveState(*(jnp.float64(value) for value in start))
    return np.array(advance(coefficients(p), x, command, load, seconds / count, count))


@pytest.mark.parametrize("axis", ["x", "y"])
def test_friction_is_the_one_printed(axis):
    c = coefficients(PARAMETER_SETS[f"{axis}-coulomb"])
    for v in (1e-9, 0.5, 3.0, 8.0, 11.9, 12.1, 40.0):
        assert friction(c, 1.0, 100 * v) == pytest.approx(printed_friction(axis, v), rel=1e-12)
        assert -friction(c, -1.0, 100 * v) == pytest.approx(printed_friction(axis, -v), rel=1e-12)
    every = np.linspace(0.0, 40.0, 4001)
    assert (
        min(friction(c, sign, 100 * every).min() for sign in (1.0, -1.0)) > 14.0
    )  # it never pushes
    start_only = coefficients(PARAMETER_SETS[f"{axis}-start"])
    assert friction(start_only, 1.0, 0.0) == pytest.approx(START[axis][0])
    assert friction(start_only, -1.0, 0.0) == pytest.approx(START[axis][1])
    if axis == "y":  # eq. 28 alone does, by hand: 0.04 * 144 - 1.12 * 12 + 7.23
        assert friction(start_only, 1.0, 1200.0 - 1e-9) == pytest.approx(-0.45)


def test_without_friction_the_step_is_exact():
    """v = w + (v0 - w) exp(-t/tau), its integral, through a reversal and for any step."""
    p = PARAMETER_SETS["frictionless"]
    for count in (1, 7, 400):
        for start, command, load, t in (
            ((3.0, 0.0), 10.0, 0.0, 0.4),
            ((0.0, 900.0), -25.0, 5.0, 0.3),
        ):
            w = 28.3 * (command - load)
            v = w + (start[1] - w) * math.exp(-t / TAU)
            position = start[0] + w * t + (start[1] - w) * TAU * (1 - math.exp(-t / TAU))
            found = after(p, start, command, t, count, load)
            np.testing.assert_allclose(found, [position, v], rtol=1e-12)
    assert without_friction(PARAMETER_SETS["y-start"]) == p._replace(gain=40.0)


def test_coulomb_friction_is_exact_through_stop_and_break_away():
    """By hand: from 900 BLU/s under -25 units against 15, to a stop and away again."""
    p = without_friction(FeedDriveParameters())._replace(coulomb=15.0)
    w = 28.3 * (-25.0 - 15.0)
    stop = TAU * math.log((w - 900.0) / w)
    stop_position = w * stop + 900.0 * TAU
    rest, away = 0.2 - stop, 28.3 * (-25.0 + 15.0)
    v = away * (1 - math.exp(-rest / TAU))
    position = stop_position + away * rest - TAU * v
    for count in (1, 3, 50):
        found = after(p, (0.0, 900.0), -25.0, 0.2, count)
        np.testing.assert_allclose(found, [position, v], rtol=1e-12)
        held = after(p, (0.0, 900.0), 0.0, 0.2, count)  # and without a command it stays
        w0 = -28.3 * 15.0
        stop0 = TAU * math.log((w0 - 900.0) / w0)
        np.testing.assert_allclose(held, [w0 * stop0 + 900.0 * TAU, 0.0], rtol=1e-12)


def by_scipy(axis, start, command, seconds):
    """A tight adaptive solution; the command exceeds the break-away level, so nothing sticks."""

    def rate(t, x):
        return [x[1], (28.3 * (command - printed_friction(axis, x[1] / 100)) - x[1]) / TAU]

    return solve_ivp(rate, (0.0, seconds), start, "DOP853", rtol=1e-11, atol=1e-10).y[:, -1]


@pytest.mark.parametrize("axis", ["x", "y"])
@pytest.mark.parametrize(
    ("start", "command"),
    [((0.0, 100.0), 45.0), ((0.0, 3000.0), -40.0), ((0.0, -700.0), -25.0), ((0.0, 0.0), 70.0)],
)
def test_motion_with_friction_is_scipys(axis, start, command):
    """Through the end of the low velocities, a stop and a break-away, to 0.1 and 0.02 BLU."""
    wanted = by_scipy(axis, start, command, 0.3)
    p = PARAMETER_SETS[f"{axis}-coulomb"]
    assert abs(after(p, start, command, 0.3, 30) - wanted).max() < 0.1  # T = 10 ms
    assert abs(after(p, start, command, 0.3, 120) - wanted).max() < 0.02


@pytest.mark.parametrize("axis", ["x", "y"])
@pytest.mark.parametrize("rise", [0.0, 2.5])
def test_axis_at_rest_sticks_up_to_the_break_away_level(axis, rise):
    p = PARAMETER_SETS[f"{axis}-coulomb"]._replace(stiction_rise=rise)
    for sign, start in zip((1, -1), START[axis], strict=True):
        level = 15.0 + start + rise
        for command, load in ((sign * level, 0.0), (0.0, -sign * level), (3.0, 3.0 - sign * level)):
            above = np.nextafter(level, np.inf) - level + 1e-12
            held = after(p, (7.0, 0.0), command - sign * 1e-12, 1.0, 100, load)
            np.testing.assert_array_equal(held, [7.0, 0.0])
            assert sign * after(p, (7.0, 0.0), command + sign * above, 1.0, 100, load)[1] > 0
    exact = without_friction(p)._replace(coulomb=16.0)
    assert after(exact, (0.0, 0.0), 16.0, 0.1, 10)[1] == 0.0
    assert after(exact, (0.0, 0.0), np.nextafter(16.0, 17.0), 0.1, 10)[1] > 0.0
    assert after(exact, (0.0, 0.0), -16.0, 0.1, 10)[1] == 0.0
    assert after(exact, (0.0, 0.0), np.nextafter(-16.0, -17.0), 0.1, 10)[1] < 0.0


def test_converter_takes_whole_units_within_its_limits():
    c = coefficients(FeedDriveParameters())
    for command, wanted in (
        (0.4, 0.0), (0.6, 1.0), (-0.6, -1.0), (12.49, 12.0), (-12.51, -13.0),
        (126.6, 127.0), (127.4, 127.0), (900.0, 127.0), (-127.7, -128.0), (-900.0, -128.0),
    ):  # fmt: skip
        assert accepted(c, command) == wanted
    narrow = coefficients(FeedDriveParameters(lowest_command=-20.0, highest_command=30.0))
    assert (accepted(narrow, -50.0), accepted(narrow, 50.0)) == (-20.0, 30.0)


def test_encoder_reports_whole_units_and_leaves_the_velocity():
    c = coefficients(FeedDriveParameters())
    for position, wanted in ((0.4, 0.0), (0.6, 1.0), (-0.6, -1.0), (4000.49, 4000.0)):
        assert FEED_DRIVE.measured(c, FeedDriveState(position, 12.3)) == (wanted, 12.3)
    assert FEED_DRIVE.signals(c, FeedDriveState(2.0, 3.0)) == {"position": 2.0, "velocity": 3.0}
    units = {"error": "BLU", "error_rate": "BLU/s", "command": "unit", "load": "unit"}
    assert {**units, "position": "BLU", "velocity": "BLU/s"} == FEED_DRIVE.units


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("gain", 0.0),
        ("gain", math.nan),
        ("time_constant", -1.0),
        ("coulomb", -1.0),
        ("negative_start", 6.4),
        ("lowest_command", 0.0),
        ("mass", 1.0),
        ("positive_slope", -9.0),
        ("positive_slope", -1e300),
        ("negative_slope", -8.0),
    ],
)
def test_an_axis_that_is_impossible_is_refused_by_its_key(name, value):
    with refused() as found:
        api.load_scenario({"plant": {"name": "feed-drive", "parameters": {name: value}}})
    assert f"plant.parameters.{name}" in found.refusal


# The paper's machine: two axes, T = 10 ms, whole BLUs from interpolator and encoder, whole units
# to the amplifier. Both controllers are plain transcriptions, so that the figures test the plant.
SUBSTEPS = 4


@jax.jit
def sample(c, x, command):
    """What both encoders read after the next 10 ms under ``command``, and the state."""

    def one(c, x, command):
        held = accepted(c, command)
        moved = jax.lax.fori_loop(
            0, SUBSTEPS, lambda _, x: step(c, x, held, FREE, 0.01 / SUBSTEPS), x
        )
        return moved, FEED_DRIVE.measured(c, moved).position

    return jax.vmap(one)(c, x, command)


def circle(controller, sets, radius, cycles):
    """Axial X and contour error [BLU], (cycles, 2000) each, of a circle in 20 s."""
    p = FeedDriveParameters(*np.transpose([PARAMETER_SETS[name] for name in sets]))
    c = coefficients(p)
    x = FeedDriveState(jnp.array([radius, 0.0]), jnp.zeros(2))
    seen, laws, axial, contour = np.array([radius, 0.0]), [controller(), controller()], [], []
    for k in range(2000 * cycles):
        angle = 2 * math.pi * k / 2000
        reference = radius * np.array([math.cos(angle), math.sin(angle)])
        position = np.asarray(x.position)
        axial.append(reference[0] - position[0])
        contour.append(math.hypot(*position) - radius)
        errors = np.round(reference) - seen
        command = np.array([law(error) for law, error in zip(laws, errors, strict=True)])
        x, read = sample(c, x, command)
        seen = np.asarray(read)
    return np.reshape(axial, (cycles, 2000)), np.reshape(contour, (cycles, 2000))


def pid():
    """PID of JK04 5.1.2 on the time scale: the integral of e dt and the derivative de / T."""
    integral, previous = 0.0, 0.0

    def law(e):
        nonlocal integral, previous
        integral += e * 0.01
        change, previous = e - previous, e
        return 1.5 * e + 8.1 * integral + 0.1 * change / 0.01

    return law


def flc(factor=1.0):
    """FLC of JK04 Tables 1 and 3 without an integral; 0 where no rule fires."""
    previous, table = 0.0, factor * np.array(rule_singletons("I"))

    def law(e):
        nonlocal previous
        change, previous = e - previous, e
        return output(ERROR_TERMS, CHANGE_TERMS, table, e, change)

    return law


def rms(values):
    return np.sqrt(np.mean(values**2, axis=-1))


def test_pid_with_coulomb_friction_has_the_published_contour_errors():
    """Fig. 12(b): RMS 3.4 and maximum 15.6 BLU; independently found for F_c = 15: 3.52, 15.9."""
    _, contour = circle(pid, ["x-coulomb", "y-coulomb"], 2000.0, 2)
    np.testing.assert_allclose(rms(contour), 3.4, rtol=0.1)
    np.testing.assert_allclose(abs(contour).max(axis=1), 15.6, rtol=0.1)
    np.testing.assert_allclose(rms(contour)[1:], 3.52, rtol=0.015)  # after the start
    np.testing.assert_allclose(abs(contour).max(axis=1), 15.9, rtol=0.02)


def test_pid_without_friction():
    """Independently found: 0.88 BLU; the paper prints 1.5, which needs a dead zone."""
    _, contour = circle(pid, ["frictionless", "frictionless"], 2000.0, 2)
    np.testing.assert_allclose(rms(contour), 0.88, atol=0.02)


def test_flc_with_start_friction_has_the_published_axial_error():
    """Fig. 10(a): approximately 16.2 BLU in every cycle."""
    axial, _ = circle(flc, ["x-start", "y-start"], 4000.0, 2)
    np.testing.assert_allclose(rms(axial), 16.2, atol=0.3)


def test_flc_with_doubled_singletons_needs_no_other_plant():
    """Fig. 10(a) on the plant of Fig. 12: independently found 17.1 BLU, printed 16.2."""
    axial, contour = circle(lambda: flc(2.0), ["x-coulomb", "y-coulomb"], 4000.0, 2)
    np.testing.assert_allclose(rms(axial), 16.2, rtol=0.07)
    np.testing.assert_allclose(rms(axial)[1], 17.1, atol=0.05)
    assert rms(contour)[-1] > 5.0
