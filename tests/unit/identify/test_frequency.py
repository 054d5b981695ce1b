"""Frequency responses of logs, against two masses of SciPy in a loop with encoder and noise."""

import numpy as np
import pytest
from carts import CART, EVERY
from scipy.signal import cont2discrete
from wording import refused

from hfc_design.identify.frequency import measured_response
from hfc_design.identify.recording import Recording

STEPS, ENCODER, NOISE = 20_000, 1e-6, 1e-6  # 20 s; [m]


def two_masses(hz, damping, share, driven):
    """Matrices per sample: the mass that is measured, the force on the other, or on itself."""
    mass, swings = 2.0 * (1.0 - share), 2.0 * share
    k = (2.0 * np.pi * hz) ** 2 / (1.0 / mass + 1.0 / swings)
    d = 2.0 * damping * k / (2.0 * np.pi * hz)
    a = np.array([[0, 1, 0, 0], [-k, -d, k, d], [0, 0, 0, 1], [k, d, -k, -d - 8.0]], float)
    a[1] /= swings
    a[3] /= mass
    seen = np.eye(4)[2 if driven else 0][None]
    force = np.array([[0.0], [0.0], [0.0], [1.0 / mass]])
    poles = np.linalg.eigvals(a)
    pole = poles[np.argmax(poles.imag)]
    system = cont2discrete((a, force, seen, np.zeros((1, 1))), EVERY)
    return system, abs(pole) / (2.0 * np.pi), -pole.real / abs(pole)


def closed_loop(system, added, seed):
    """Command and measured position under a lagged PD, with a signal added to the command."""
    (a, b, c, *_), noise = system, np.random.default_rng(seed).normal(0.0, NOISE, STEPS)
    x, before, command, place = np.zeros(4), 0.0, np.empty(STEPS), np.empty(STEPS)
    for k in range(STEPS):
        y = np.round((c[0] @ x + noise[k]) / ENCODER) * ENCODER
        command[k] = added[k] - 2e3 * y - 20.0 * (y - before) / EVERY
        place[k], before = y, y
        x = a @ x + b[:, 0] * command[k]
    return command, place


def recorded(place, command, added, reference=None):
    still, usable = np.zeros(len(place)), np.ones(len(place))
    return Recording({"place": place}, command, reference, still, added, usable, EVERY, 0.0)


@pytest.mark.parametrize(
    ("hz", "damping", "driven"), [(55.0, 0.02, True), (120.0, 0.01, False), (180.0, 0.06, True)]
)
def test_mode_drive_and_loop_are_those_of_the_masses(hz, damping, driven):
    """Mode within 2 % and 20 %; drive and L (its law by hand) within the errors that are told."""
    system, exact_hz, exact_damping = two_masses(hz, damping, 0.25, driven)
    added = 15.0 * np.sign(np.random.default_rng(1).normal(size=STEPS // 2)).repeat(2)
    found = measured_response(recorded(*closed_loop(system, added, 2)[::-1], added), CART, "log")
    (mode,) = found.modes
    assert mode.hz == pytest.approx(exact_hz, rel=0.02)
    assert mode.damping == pytest.approx(exact_damping, rel=0.2)
    assert abs(mode.hz - exact_hz) < 4.0 * mode.error_hz
    clear = (found.coherence > 0.98) & (found.hertz > 3.0)
    angles = 2.0 * np.pi * found.hertz[clear] * EVERY
    a, b, c, *_ = system
    z = np.exp(1j * angles)[:, None, None]
    drive = (c @ np.linalg.solve(z * np.eye(4) - a, b.astype(complex)))[:, 0, 0]
    off = np.abs(found.drive[0, clear] / drive - 1.0)
    assert np.median(off) < 0.03
    assert 0.5 < np.sqrt(np.mean(off**2 / (2.0 * found.error[clear] ** 2))) < 1.5
    law = 2e3 + 20.0 * (1.0 - np.exp(-1j * angles)) / EVERY
    assert np.median(np.abs(found.loop[0, clear] / (drive * law) - 1.0)) < 0.03


def test_a_closed_loop_without_an_outer_signal_is_told_to_be_biased():
    system, *_ = two_masses(55.0, 0.02, 0.25, True)
    added = np.random.default_rng(1).normal(0.0, 15.0, STEPS)
    command, place = closed_loop(system, added, 2)
    still = np.zeros(STEPS)
    (note,) = measured_response(recorded(place, command, still), CART, "log").notes
    assert "biased by noise" in note
    reference = np.cumsum(np.random.default_rng(3).normal(0.0, 1e-6, STEPS))
    assert not measured_response(recorded(place, command, added, reference), CART, "log").notes


def test_logs_without_command_excitation_or_length_are_refused():
    noise = np.random.default_rng(4).normal(0.0, 1.0, (2, STEPS))
    still = np.zeros(STEPS)
    for log, word in (
        (recorded(noise[0], None, still), "command"),
        (recorded(noise[0], noise[1], still), "coherence"),
        (recorded(noise[0, :100], noise[1, :100], still[:100]), "samples"),
    ):
        with refused() as found:
            measured_response(log, CART, "log.csv")
        assert word in found.refusal
