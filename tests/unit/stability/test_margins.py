"""Margins of sampled loops: closed forms by hand, and poles of changed loops by NumPy."""

import control
import numpy as np
import pytest
from scipy.signal import cont2discrete, place_poles
from shaken import shaken

from hfc_design.stability.margins import FREQUENCIES, OpenLoop, largest
from hfc_design.stability.margins import margins as margins_of


def margins(loop):
    """With a sample time of 1 / 2 pi s, frequencies are angles per sample."""
    return margins_of(loop, 0.5 / np.pi)


def integrator(gain):
    """``x(k+1) = x + u``, ``u = -gain x``."""
    return OpenLoop(np.eye(1), np.ones(1), np.array([-gain]))


@pytest.mark.parametrize("gain", [0.02, 0.5, 1.7])
def test_an_integrator_by_hand(gain):
    """The pole is 1 - k, so that 2/k more gain makes it -1; |e^(iw) - 1| = 2 sin(w/2) = k."""
    found = margins(integrator(gain))
    crossing = 2.0 * np.arcsin(gain / 2.0)
    phase = 90.0 - np.degrees(crossing / 2.0)
    assert found.stable
    assert found.slowest_pole == pytest.approx(abs(1.0 - gain))
    assert found.gain_up == pytest.approx(2.0 / gain)
    assert found.gain_down is None
    assert found.phase_deg == pytest.approx(phase)
    assert found.delay_samples == pytest.approx(np.radians(phase) / crossing)


def test_a_loop_that_is_not_stable_says_so():
    found = margins(integrator(2.5))
    assert not found.stable
    assert found.gain_down == pytest.approx(2.0 / 2.5)
    assert found.phase_deg is None  # sin does not reach 1.25
    assert found.sensitivity == pytest.approx(4.0)  # at pi: (z - 1) / (z - 1 + 2.5)


@pytest.mark.parametrize("gain", [0.02, 0.3])
def test_a_sample_of_delay_takes_its_lag_off_the_phase_margin(gain):
    """By hand: it turns the loop by its angle; z^2 - z + k has its poles inside up to k = 1."""
    late = OpenLoop(np.array([[1.0, 1.0], [0.0, 0.0]]), np.array([0.0, 1.0]), np.array([-gain, 0]))
    before, found = margins(integrator(gain)), margins(late)
    crossing = 2.0 * np.arcsin(gain / 2.0)  # rad a sample, where it was: |z^-1| = 1
    assert found.phase_deg == pytest.approx(before.phase_deg - np.degrees(crossing))
    assert found.delay_samples == pytest.approx(before.delay_samples - 1.0)
    assert found.gain_up == pytest.approx(1.0 / gain)
    assert (found.crossover_hz, before.crossover_hz) == pytest.approx((crossing, crossing))
    roots = np.roots([1.0, -1.0, gain])
    assert found.slowest_pole == pytest.approx(np.abs(roots).max())


@pytest.mark.parametrize("gain", [0.02, 0.5, 1.7])
def test_the_peaks_and_the_band_of_an_integrator_by_hand(gain):
    """S = (z - 1) / (z - 1 + k) and T = k / (z - 1 + k): both are largest at an end."""
    found = margins(integrator(gain))
    assert found.sensitivity == pytest.approx(2.0 / (2.0 - gain))
    assert found.sensitivity_hz == pytest.approx(np.pi)
    assert found.disk == pytest.approx(2.0 / ((2.0 + gain) / (2.0 - gain)))
    # |z - 1 + k|^2 = 2 (1 - k) (1 - cos w) + k^2, which is twice k^2 there but for 10^0.3.
    cosine = 1.0 - gain**2 * (10.0**0.3 - 1.0) / (2.0 * (1.0 - gain))
    if -1.0 < cosine < 1.0:
        assert found.bandwidth_hz == pytest.approx(np.arccos(cosine))
    else:
        assert found.bandwidth_hz is None


def test_what_stays_as_it_is_is_no_part_of_a_loop():
    """A rule that nothing moves, and a deflection that nobody reads: poles of 1 beside the loop."""
    one, rest = integrator(0.5), np.eye(2)
    a = np.block([[one.a, np.array([[0.0, 0.0]])], [np.zeros((2, 1)), rest]])
    heard, moved = np.array([-0.5, 3.0, 0.0]), np.array([1.0, 0.0, 2.0])
    found, expected = margins(OpenLoop(a, moved, heard)), margins(one)
    assert found.stable
    assert found.slowest_pole == pytest.approx(expected.slowest_pole)
    assert found.gain_up == pytest.approx(expected.gain_up)


def test_the_largest_answer_of_a_closed_loop_by_a_hundred_thousand_points():
    a = np.array([[0.9, 0.3], [-0.3, 0.9]])
    b, c = np.array([0.1, 1e-6]), np.array([1e-5, 2e-5])
    z = np.exp(1j * np.linspace(1e-6, np.pi, 100_001))
    sizes = np.abs(np.linalg.solve(z[:, None, None] * np.eye(2) - a, b[:, None])[..., 0] @ c)
    peak, slow = largest(OpenLoop(a, b, c))
    assert peak == pytest.approx(sizes.max(), rel=1e-6)
    assert slow == pytest.approx(sizes[0], rel=1e-6)


def random_loop(seed, unstable):
    """A drive of three states, two of them slow, and gains that place stable poles."""
    random = np.random.default_rng(seed)
    a = np.array([[0.0, 1.0, 0.0], [2.0 if unstable else 0.0, -1.0, 3.0], [0.0, -1.0, -20.0]])
    a, b, *_ = cont2discrete((a, np.array([[0.0], [0.0], [20.0]]), np.eye(3), 0), 0.01)
    poles = np.exp(-0.01 * random.uniform(2.0, 30.0, 3))
    return OpenLoop(a, b[:, 0], -place_poles(a, b, poles).gain_matrix[0])


@pytest.mark.parametrize("unstable", [False, True])
@pytest.mark.parametrize("seed", range(4))
def test_python_control_finds_the_same(seed, unstable):
    """Within 0.1 % and 0.1 degree, of loops that a sample of delay makes cross -180 degrees."""
    one = random_loop(seed, unstable)
    a = np.block([[one.a, one.b[:, None]], [np.zeros((1, len(one.b) + 1))]])
    loop = OpenLoop(a, np.append(0.0 * one.b, 1.0), 3.0 * np.append(one.c, 0.0))
    other = control.ss(loop.a, loop.b[:, None], -loop.c, 0.0, dt=1.0)
    with np.errstate(all="ignore"):
        gains, phases, nearest, _, crossed, _ = control.stability_margins(other, returnall=True)
        disk, *_ = control.disk_margins(other, np.geomspace(1e-5, np.pi, 4_001))
    found = margins(loop)
    assert found.gain_up == pytest.approx(gains[gains > 1.0].min(), rel=1e-3)
    assert (found.gain_down or gains[0]) == pytest.approx(gains[0], rel=1e-3)
    assert found.phase_deg == pytest.approx(phases.min(), abs=0.1)
    assert found.delay_samples == pytest.approx((np.radians(phases) / crossed).min(), rel=1e-3)
    assert found.sensitivity == pytest.approx(1.0 / nearest.min(), rel=1e-3)
    assert found.disk == pytest.approx(disk, rel=1e-3)


def test_a_lead_that_is_missing_less_than_a_lag_is_the_phase_margin():
    """L = -1.2 / (z + 0.5) has the size 1 where cos w = 0.19; led by arg(z + 0.5) it is -1."""
    found = margins(OpenLoop(np.array([[-0.5]]), np.ones(1), np.array([1.2])))
    angle = np.arccos(0.19)
    lead = np.degrees(np.arctan2(np.sin(angle), np.cos(angle) + 0.5))
    assert found.stable  # its pole is 0.7
    assert found.phase_deg == pytest.approx(lead)
    assert found.delay_samples == pytest.approx(np.radians(360.0 - lead) / angle)


@pytest.mark.parametrize("place", [135, 360, 540])
def test_a_crossing_at_an_angle_that_is_looked_at_is_not_missed(place):
    """|e^(iw) - 1| = 2 sin(w/2) = k there, but for its last bits."""
    angle = np.pi * FREQUENCIES[place]
    for (gain,) in shaken(2.0 * np.sin(angle / 2.0), times=40, size=3e-16):
        assert margins(integrator(gain)).phase_deg == pytest.approx(90.0 - np.degrees(angle / 2.0))
    loop = two_masses(1)
    size = float(np.abs(loop.transfer(np.array([angle])))[0])
    found = [margins(loop._replace(c=loop.c * x)) for (x,) in shaken(1.0 / size, size=3e-16)]
    for one in found:
        assert one.phase_deg == pytest.approx(found[0].phase_deg, rel=1e-9)


def two_masses(seed):
    """Two masses, a spring between them and nothing else, and a PD on the first one."""
    random = np.random.default_rng(seed)
    one, other = random.uniform(0.5, 5.0, 2)
    k, every = 10.0 ** random.uniform(2.0, 6.0), 10.0 ** random.uniform(-4.5, -2.5)
    d = 0.1 * np.sqrt(k * min(one, other))
    pair = np.array([-k, -d, k, d])
    a = np.array([[0.0, 1.0, 0.0, 0.0], pair / one, [0.0, 0.0, 0.0, 1.0], -pair / other])
    a, b, *_ = cont2discrete((a, np.array([[0.0], [1 / one], [0.0], [0.0]]), np.eye(4), 0), every)
    speed = min(0.05 / every, 0.2 * np.sqrt(k / (one + other)))
    gains = (one + other) * np.array([speed**2, 2.0 * speed, 0.0, 0.0])
    return OpenLoop(a, b[:, 0], -gains)


def test_two_integrators_have_no_margin_downwards_by_their_last_bits():
    """Less gain on a PD and two masses is a slower loop, and no loop that swings."""
    for seed in (14, 36, 42, 44, 45, 50, 53):
        found = margins(two_masses(seed))
        assert found.stable
        assert found.gain_down is None
        assert 1.0 < found.gain_up < 1e6
