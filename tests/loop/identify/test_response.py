"""What a log says against a model: carts of SciPy with a mode, a lag, a load, another half."""

import numpy as np
import pytest
from carts import CART, EVERY, Cart, driven, noisy, recorded
from scipy.signal import butter, cont2discrete, dlsim, sosfilt, sosfreqz

from hfc_design.identify.fit import by_command
from hfc_design.identify.identifiability import certainty, widened_by_halves
from hfc_design.identify.parameters import free_parameters
from hfc_design.identify.response import KNOWN, response

STEPS, NOISE = 4000, 1e-8  # [m]
NAMES = ("mass", "viscous_friction", "pull")


def shaken_to(hz, size=20.0):
    """(steps,) a force of noise up to a frequency."""
    noise = np.random.default_rng(1).normal(0.0, size, STEPS)
    return sosfilt(butter(8, hz, fs=1.0 / EVERY, output="sos"), noise)


def held(rates, pushed, force):
    """(steps,) the first state of a linear system under a force that is held in each sample."""
    first = np.eye(1, len(rates))
    system = cont2discrete((rates, pushed, first, np.zeros((1, 1))), EVERY)
    return dlsim(system, force)[1][:, 0]


def swinging(force, hz, damping=0.02, share=0.25):
    """(steps,) the mass that swings, a ``share`` of all, on the one that is pushed."""
    mass, swings = 2.0 * (1.0 - share), 2.0 * share
    k = (2.0 * np.pi * hz) ** 2 / (1.0 / mass + 1.0 / swings)
    d = 2.0 * damping * k / (2.0 * np.pi * hz)
    a, b = np.array([k, d]) / swings, np.array([k, d]) / mass
    rates = np.zeros((4, 4))
    rates[0, 1] = rates[2, 3] = 1.0
    rates[1] = -a[0], -a[1], a[0], a[1]
    rates[3] = b[0], b[1], -b[0], -b[1] - 8.0 / mass
    return held(rates, np.array([[0.0], [0.0], [0.0], [1.0 / mass]]), force - 0.5)


def fitted(place, force, names=NAMES, **changes):
    told = recorded(place, force)
    wanted = free_parameters(CART, changes, names)
    return by_command(wanted, told, 1, [20.0], 0, near=True)


@pytest.mark.parametrize("hz", [160.0, 250.0])
def test_no_mode_is_told_of_what_was_not_excited(hz):
    """Only where it lies just above; far below a mode any other error of the model looks alike."""
    force = shaken_to(80.0)
    own = response(fitted(noisy(swinging(force, hz), NOISE, 0), force))
    assert (own.mode, own.top < hz) == (None, True)
    assert not any("there is a mode" in line for line in own.lines())


@pytest.mark.parametrize("top", [30.0, 90.0])
def test_a_model_that_is_right_has_no_mode_and_nothing_is_known_above_what_was_excited(top):
    force = shaken_to(top)
    own = response(fitted(noisy(driven(Cart(), force), NOISE, 0), force))
    assert own.mode is None
    # Where noise is as large a share of the position as is allowed, by the filter and the mass.
    sections = butter(8, top, fs=1.0 / EVERY, output="sos")
    passed = np.abs(sosfreqz(sections, own.frequency, fs=1.0 / EVERY)[1])
    noise = NOISE / (20.0 * passed / (2.0 * (2.0 * np.pi * own.frequency) ** 2))
    expected = own.frequency[np.flatnonzero(noise < KNOWN)[-1]]
    assert 0.8 * expected < own.top <= 1.02 * expected
    told = (own.frequency > 3.0) & (own.frequency < top)
    turn = 2j * np.pi * own.frequency[told]
    exact = 1.0 / (2.0 * turn**2 + 8.0 * turn)
    for curve in (own.log, own.model):
        np.testing.assert_allclose(np.abs(curve[told] / exact), 1.0, atol=0.1)


def test_a_lag_is_told_from_a_delay_where_there_is_one():
    """Three samples of lag and one of delay; then four of delay."""
    force, mass = shaken_to(90.0), 2.0
    rates = np.array([[0.0, 1.0, 0.0], [0.0, -8.0 / mass, 1.0 / mass], [0.0, 0.0, -1.0 / 3e-3]])
    later = np.r_[0.0, force[:-1]]
    lagged = held(rates, np.array([[0.0], [0.0], [1.0 / 3e-3]]), later)
    one = fitted(noisy(lagged, NOISE, 0), force, pull=-1e-9)
    assert (one.lag, one.late) == pytest.approx((3.0, 4.0), abs=0.05)
    late = driven(Cart(pull=0.0), np.r_[[0.0] * 4, force[:-4]])
    other = fitted(noisy(late, NOISE, 0), force, pull=-1e-9)
    assert (other.lag, other.late) == pytest.approx((0.0, 4.0), abs=0.02)


def test_a_load_is_found_in_its_unit():
    force = shaken_to(30.0)
    place = noisy(driven(Cart(pull=0.5 + 7.3), force), NOISE, 0)
    found = fitted(place, force, ("mass", "viscous_friction", "load"))
    assert found.values[2] == pytest.approx(7.3, rel=1e-3)


def test_halves_that_differ_widen_the_intervals():
    """A quarter more viscous friction from the middle on, beside one that is the same."""
    force, half = shaken_to(30.0), STEPS // 2
    first = driven(Cart(), force)
    rates = np.array([[0.0, 1.0, 0.0], [0.0, -5.0, 0.5], [0.0, 0.0, 0.0]])
    exact = cont2discrete((rates, np.zeros((3, 1)), np.eye(1, 3), np.zeros((1, 1))), EVERY)[0]
    speed = (first[half] - first[half - 2]) / (2.0 * EVERY)
    state, second = np.array([first[half - 1], speed, 0.0]), []
    for push in force[half - 1 : -1]:
        state = exact @ np.array([*state[:2], push - 0.5])
        second.append(state[0])
    for place, wider in ((first, False), (np.r_[first[:half], second], True)):
        found = fitted(noisy(place, 1e-6, 0), force)
        known = certainty(found)
        own, told = widened_by_halves(found, known._replace(state=("yes",) * 3))
        assert bool(told) == wider
        if wider:
            assert "viscous_friction" in told
            assert known.high[1] - known.low[1] < 1.0
            assert own.low[1] < 8.1
            assert own.high[1] > 9.9


def test_a_log_without_excitation_is_told_in_a_line():
    """A cart that only coasts under noise of the force too small to be seen."""
    force = 0.5 + 8.0 * 0.1 + np.random.default_rng(2).normal(0.0, 1e-6, STEPS)
    place = noisy(0.1 * EVERY * np.arange(STEPS), 1e-5, 0)
    own = response(fitted(place, force, ("pull",)))
    assert own.top is None
    (line,) = own.lines()
    assert line.startswith("DOUBTFUL: the log has no excitation")
