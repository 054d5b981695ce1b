"""The positioning stage against hand calculations in SI units and SciPy with events."""

import driven
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plants.positioning_stage import (
    POSITIONING_STAGE,
    PositioningStageParameters,
    PositioningStageState,
    coefficients,
    top_speed,
)

NOMINAL = PositioningStageParameters()
LOPSIDED = NOMINAL._replace(viscous_asymmetry=0.3, stiction_rise=4.0)


def path(p, start, voltages, dt=1e-3, load=0.0):
    """(steps, 2) positions and velocities in mm and s."""
    return driven.path(POSITIONING_STAGE, p, start, voltages, dt, load)


def after(p, start, voltage, seconds, count=1, load=0.0):
    return path(p, start, [voltage] * count, seconds / count, load)[-1]


def braked(p, direction):
    """Coulomb friction with the offset [N], viscous friction [N s/m], in a direction."""
    return (
        p.coulomb_friction + direction * p.offset,
        p.viscous_friction * (1.0 + direction * p.viscous_asymmetry),
    )


def by_scipy(p, start, voltage, seconds, load=0.0):
    """The stage in m, N and s: slides until an event of v = 0, then sticks or goes on."""
    place, speed, left = start[0] / 1e3, start[1] / 1e3, seconds
    while left > 0:
        push = p.amplifier_gain * voltage - load
        if speed == 0.0:
            level = p.coulomb_friction + p.stiction_rise
            if abs(push - p.offset) <= level:
                break
        way = np.sign(speed or push - p.offset)
        constant, viscous = braked(p, way)

        def rate(t, x, push=push, way=way, constant=constant, viscous=viscous):
            return [x[1], (push - way * constant - viscous * x[1]) / p.mass]

        def stops(t, x, way=way):
            return x[1] if t > 0 else way

        stops.terminal, stops.direction = True, -way
        found = solve_ivp(rate, (0.0, left), [place, speed], "DOP853", events=stops, **TIGHT)
        place, speed = found.y[:, -1]
        left -= found.t[-1]
        if found.status == 1:
            speed = 0.0
    return 1e3 * np.array([place, speed])


TIGHT = {"rtol": 1e-12, "atol": 1e-14}
CASES = {
    "breaks away forwards": ((0.0, 0.0), 2.0, 0.0, 0.3),
    "breaks away backwards": ((0.0, 0.0), -2.0, 0.0, 0.3),
    "coasts to rest": ((5.0, 120.0), 0.0, 0.0, 1.5),
    "brakes, stops and turns round": ((5.0, 120.0), -4.0, 0.0, 0.4),
    "stops and is held": ((0.0, -60.0), 0.55, 0.0, 0.8),
    "is driven back by a load": ((0.0, 40.0), 0.0, 60.0, 0.5),
}


@pytest.mark.parametrize("case", CASES)
def test_motion_is_scipys(case):
    """Exact where forwards and backwards brake alike, else within 4 nm, 0.1 um/s at 1 ms."""
    start, voltage, load, seconds = CASES[case]
    count = round(seconds / 1e-3)
    for p, n, within in ((NOMINAL, 1, 1e-8), (NOMINAL, count, 1e-8), (LOPSIDED, count, 4e-6)):
        off = after(p, start, voltage, seconds, n, load) - by_scipy(
            p, start, voltage, seconds, load
        )
        assert (abs(off) <= (within, 25 * within)).all()


@pytest.mark.parametrize("p", [NOMINAL, LOPSIDED])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_it_breaks_away_above_the_published_friction_and_tends_to_the_speed_of_its_force(p, way):
    """By hand: 20.39 -+ 3.16 N at 35.15 N/V; then u g = F_c +- offset + F_v v."""
    constant, viscous = braked(p, way)
    level = way * (constant + p.stiction_rise) / 35.1507
    held = after(p, (7.0, 0.0), level * (1 - 1e-9), 1.0)
    np.testing.assert_array_equal(held, [7.0, 0.0])
    assert way * after(p, (7.0, 0.0), level * (1 + 1e-9), 1.0)[1] > 0.0
    ten_volts = way * 1e3 * (351.507 - constant) / viscous
    assert after(p, (0.0, 0.0), way * 10.0, 30.0, 3000)[1] == pytest.approx(ten_volts, rel=1e-9)
    assert top_speed(p) <= abs(ten_volts) * (1 + 1e-12)


@pytest.mark.parametrize("p", [NOMINAL, LOPSIDED])
def test_friction_takes_all_the_work_that_does_not_become_speed(p):
    """In N and m: work of motor and offset = kinetic energy + what friction takes, in the mean."""
    random = np.random.default_rng(2)
    voltages = np.repeat(random.uniform(-6.0, 6.0, 40), 100)
    states = np.concatenate([[[0.0, 0.0]], path(p, (0.0, 0.0), voltages)]) / 1e3
    ways, speed = np.diff(states[:, 0]), states[:, 1]
    work = (p.amplifier_gain * voltages - p.offset) * ways
    energy = np.diff(0.5 * p.mass * speed**2)
    assert (work - energy >= -1e-12).all()
    middle = 0.5 * (speed[1:] + speed[:-1])
    viscous = p.viscous_friction * (1.0 + np.sign(middle) * p.viscous_asymmetry)
    taken = p.coulomb_friction * abs(ways) + viscous * middle * ways
    assert taken.sum() == pytest.approx((work - energy).sum(), rel=1e-4)
    assert energy.sum() < 0.5 * work.sum()


def test_the_encoder_counts_and_the_command_is_bound():
    c = coefficients(NOMINAL._replace(encoder_resolution=2e-4, highest_voltage=5.0))
    seen = POSITIONING_STAGE.measured(c, PositioningStageState(0.00031, 1.3))
    assert seen == pytest.approx((0.0004, 1.3))
    ideal = coefficients(NOMINAL)
    assert POSITIONING_STAGE.measured(ideal, PositioningStageState(0.00031, 1.3)) == (0.00031, 1.3)
    assert [POSITIONING_STAGE.accepted(c, u) for u in (-12.0, 4.0, 12.0)] == [-5.0, 4.0, 5.0]
