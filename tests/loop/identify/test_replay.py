"""What a replay shifts, and what it takes the load to be between samples."""

from dataclasses import replace

import jax
import numpy as np
import pytest
from carts import CART, EVERY, Cart, driven, forced, recorded

from hfc_design.files.loop_setup import load_design, own_scenario
from hfc_design.identify.parameters import free_parameters
from hfc_design.identify.recording import Recording
from hfc_design.identify.replay import closed_loop_residual, delayed, replay, rigid_body
from hfc_design.simulation.evaluating import evaluate
from plants import PLANTS


def shares(drive, **changes):
    return {name: x for name, (_, x) in rigid_body(drive, drive.parameters(**changes))}


def test_an_axis_goes_as_one_body_through_its_gears():
    """The rotor turns gear_ratio times as far, the nut as far as the table, without backlash."""
    c_axis = PLANTS["c-axis"]
    expected = {"spindle_angle": 1.0, "rotor_angle": 2.0}
    assert shares(c_axis, gear_ratio=2.0) == pytest.approx(expected)
    assert dict(rigid_body(c_axis, c_axis.parameters()))["rotor_angle"][0] == "rotor_velocity"
    table = {"position": 1.0, "motor_position": 1.0}
    assert shares(PLANTS["milling-table"]) == pytest.approx(table)
    assert shares(CART) == pytest.approx({"position": 1.0})


def test_a_command_that_acts_later():
    command = np.array([1.0, 3.0, 2.0, 2.0])
    np.testing.assert_allclose(delayed(command, 1.0), [1.0, 1.0, 3.0, 2.0])
    np.testing.assert_allclose(delayed(command, 0.25), [1.0, 2.5, 2.25, 2.0])


def test_an_observer_counts_when_it_has_forgotten_how_it_began():
    """A cart that is taken for one at rest, and is not: 1e-6 of it is left where it counts.

    The observer alone, by hand: its error obeys e'' + 2 0.7 w e' + w^2 e = 0 from a rate of 0.1.
    """
    force = forced(1500)
    true = Cart(viscous_friction=1e-3)
    moving = driven(true, force) + 0.1 * EVERY * np.arange(1500)
    told = recorded(moving, force)._replace(rate=1e-12)  # 0 would be known to be at rest
    own = replay(free_parameters(CART, true._asdict(), ["mass"]), told, 5.0, 1)
    with jax.enable_x64(True):
        off = np.asarray(own(true, 0.0))[:, 0]
    first = int(np.flatnonzero(off)[0])
    assert first == pytest.approx(3.0 / 5.0 / EVERY, abs=1)
    rested = replay(
        free_parameters(CART, {}, ["mass"]), told._replace(rate=0.0), 5.0, 1
    ).rows.usable
    assert np.flatnonzero(rested)[0] == pytest.approx(1.0 / 5.0 / EVERY, abs=1)
    w, damped = 2.0 * np.pi * 5.0, np.sqrt(1.0 - 0.7**2)
    largest = 0.1 / (w * damped)  # of e, but for its decay
    assert np.abs(off[first:]).max() < 2e-5 * largest
    early = own.rows._replace(usable=np.ones(1500))
    with jax.enable_x64(True):
        before = np.asarray(replace(own, rows=early)(true, 0.0))[:, 0]
    time = EVERY * np.arange(first)
    exact = 0.1 / (w * damped) * np.exp(-0.7 * w * time) * np.sin(w * damped * time)
    np.testing.assert_allclose(before[:first], exact, atol=0.05 * largest)


def test_the_loop_that_recorded_a_log_replays_it():
    """With its own parameters less than a millionth of its way is left; with more mass far more."""
    design = load_design("emps-cascade")
    scenario = own_scenario(design, "emps-cascade", {"simulation.duration_s": 0.5})
    done = evaluate(design, scenario)
    (axis,), still = done.axes, np.zeros(len(done.time))
    place, target = (np.asarray(x) for x in (axis.motion.state.position, axis.happens.reference))
    every = scenario.simulation.sample_time_s
    told = Recording({"position": place}, None, target, still, still, still + 1.0, every, 0.0)
    replayed, (true,) = closed_loop_residual(scenario, design, told), scenario.plant.values()
    with jax.enable_x64(True):
        off, heavier = (
            np.asarray(replayed(true._replace(mass=share * true.mass), 0.0)) for share in (1.0, 1.2)
        )
    assert np.abs(off).max() < 1e-6 * np.ptp(place)
    assert np.abs(heavier).max() > 1e-4 * np.ptp(place)
