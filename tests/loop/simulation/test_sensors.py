"""What the controller is told and what becomes of its command, against SciPy and plain loops."""

from typing import Any, NamedTuple

import numpy as np
import oracle
import pytest
from scipy.signal import lfilter
from sensed import moved, scenario

import hfc_design.api as hfc

PERIOD = 1e-3


def in_steps(values, step):
    return step * np.floor(values / step + 0.5)


def differentiated(readings, bandwidth):
    """The velocity of a critically damped alpha-beta filter as a transfer function of readings."""
    pole = np.exp(-2 * np.pi * bandwidth * PERIOD)
    beta = (1 - pole) ** 2
    return lfilter([beta / PERIOD, -beta / PERIOD], np.poly([pole, pole]), readings)


@pytest.mark.parametrize("bandwidth", [5.0, 80.0, 1e4])
def test_observer_is_a_filter_of_the_readings(bandwidth):
    changes = ["velocity='observer'", f"observer_hz={bandwidth}", "noise=3e-6", "seed=4"]
    found = scenario(*(f"sensors.{x}" for x in ["encoder_resolution=1e-5", *changes]))
    motion = moved(found, kp=20.0, kd=5.0)
    noise = found.samples().axes[0].noise[1]  # of the spindle's encoder
    reading = in_steps(motion.state.spindle_angle + noise, 1e-5)
    told = (motion.command - 20.0 * (0.02 * found.simulation.time - reading)) / 5.0
    np.testing.assert_allclose(0.02 - told, differentiated(reading, bandwidth), atol=1e-9)


def test_difference_over_several_samples_is_one_of_the_readings():
    count = 5
    changes = ["velocity='encoder'", f"difference_samples={count}", "noise=3e-6"]
    found = scenario(*(f"sensors.{x}" for x in ["encoder_resolution=1e-5", *changes]))
    motion = moved(found, kp=20.0, kd=5.0)
    reading = in_steps(motion.state.spindle_angle + found.samples().axes[0].noise[1], 1e-5)
    told = (motion.command - 20.0 * (0.02 * found.simulation.time - reading)) / 5.0
    before = np.concatenate([np.zeros(count), reading[:-count]])  # it stood still
    np.testing.assert_allclose(0.02 - told, (reading - before) / (count * PERIOD), atol=1e-9)


def by_hand(samples, resolution, limit, kp=758.405, kd=743.010):
    """Commands that the C-axis is given, each acting a sample later, by a plain loop."""
    rhs = oracle.plant()
    x, waiting, given = np.zeros(6), 0.0, []
    for n in range(samples):
        command = kp * (0.02 * n * PERIOD - x[3]) + kd * (0.02 - x[4])
        command = np.clip(command, -limit, limit)
        command = resolution * np.floor(command / resolution + 0.5)
        now, waiting = waiting, command
        x = oracle.rk4(lambda t, x, now=now: rhs(x, now, 0.0), 0.0, x, PERIOD)
        given.append(command)
    return np.array(given)


def test_commands_are_bound_then_rounded_then_held_back():
    changes = ["resolution=0.4", "command=9.6", "delay_samples=1"]
    motion = moved(scenario(*(f"limits.{x}" for x in changes)))
    wanted = by_hand(500, 0.4, 9.6)
    assert len(np.unique(wanted)) > 5
    assert abs(wanted).max() == pytest.approx(9.6)
    np.testing.assert_allclose(motion.command, wanted, atol=1e-9)


class Gains(NamedTuple):
    p: Any


def test_a_reading_of_a_signal_has_steps_and_noise_of_its_own(own_plugins):
    law = hfc.Law(
        "by-current",
        Gains(p=(1.0, 100.0)),
        lambda zero: (),
        lambda T, gains, memory, signals: (5.0 - gains.p * signals["current"], memory),
    )
    hfc.register(law)
    sensors = {"noise": 1e-6, "readings": {"current": {"resolution": 0.02, "noise": 0.05}}}
    changes = {"sensors": sensors, "controller": {"kind": "by-current"}}
    found = hfc.load_scenario(scenario(), changes)
    motion = hfc.evaluate(hfc.with_gains(found, "by-current", {"p": 2.0}), found).axes[0].motion
    noise = found.samples().axes[0].noise
    assert noise.shape == (3, 500)
    assert noise[2].std() == pytest.approx(0.05, rel=0.1)
    wanted = in_steps(motion.state.current + noise[2], 0.02)
    np.testing.assert_allclose((5.0 - motion.command) / 2.0, wanted, atol=1e-12)
    # The encoders' noise is what it is without the reading.
    plain = scenario("sensors.noise=1e-6").samples().axes[0].noise
    np.testing.assert_array_equal(noise[:2], plain)


def test_an_axis_that_turns_on_is_led_to_the_nearest_place_of_a_turn():
    """A ramp of whole turns is none: an error of 2.3 turns counts as 0.3 of one."""
    turn = 1e-3
    motions = [moved(scenario(*own), kp=20.0, kd=0.0) for own in ([], [f"sensors.turn={turn}"])]
    for motion, folds in zip(motions, (False, True), strict=True):
        error = 20e-3 * 1e-3 * np.arange(len(motion.command)) - motion.state.spindle_angle
        wanted = error - turn * np.floor(error / turn + 0.5) if folds else error
        np.testing.assert_allclose(motion.error, wanted, atol=1e-12)
        np.testing.assert_allclose(motion.command, 20.0 * wanted, atol=1e-10)
    assert np.abs(motions[1].error).max() <= turn / 2 < np.abs(motions[0].error).max()
