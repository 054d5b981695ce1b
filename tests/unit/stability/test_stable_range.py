"""The stable range against frequency responses, eigenvalues and grids of JK04 eq. 21 and 22."""

import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import signal
from shaken import shaken
from wording import refused

from hfc_design.core.records import UserError
from hfc_design.stability.stable_range import stable_range

TAU, T = 0.055, 0.01
DRIVE = stable_range(28.3, TAU, T)
FASTER = stable_range(40.0, TAU, T)
# Fine everywhere and finer towards x = 1, where the printed expressions bend sharply.
X = np.unique(np.concatenate([np.linspace(-1.0, 1.0, 200_001), 1.0 - np.logspace(-12, 0, 20_001)]))


def printed_21(drive):
    """The braces of JK04 eq. 21, at x < 1."""
    k0, a, b = drive[:3]
    x = X[X < 1.0]
    above = k0 * (2 * a * x**2 + (1 + a) * (1 - b) * x - a - (1 + b) + a * b)
    return above / (2 * (x - 1) * (1 + b**2 - 2 * b * x))


def printed_22(drive, k1, x=X):
    """Both sides of JK04 eq. 22: the cubic that K_2 multiplies, and the quadratic."""
    k0, a, b = drive[:3]
    g3 = 16 * k0 * a
    g2 = 8 * k0 * ((1 - a * b) - 2 * a)
    g1 = 2 * k0 * (k0 * k1 * a - 4 * (1 - a * b) - 4 * (a + b))
    g0 = k0 * (k0 * k1 * (a**2 + 1) + 8 * (a + b))
    h2 = 8 * (k0 * k1 * a + 2 * b)
    h1 = 4 * (k0 * k1 * (1 + a) * (1 - b) - 2 * (1 + b) ** 2)
    h0 = 4 * (2 * (1 + b**2) + k0 * k1 * (-a - (1 + b) + a * b))
    return np.polyval([g3, g2, g1, g0], x), np.polyval([h2, h1, h0], x)


def largest_pole(drive, k1, k2):
    """Of the loop under u = k1 e + k2 (e(k) - e(k-1)), by eigenvalues.

    State: two states of the drive and the last error. Nothing of the module is used but the
    three numbers, and those are tested against SciPy's own discretisation.
    """
    k0, a, b = drive[:3]
    f, g, c, _ = signal.tf2ss([k0, k0 * a], np.polymul([1.0, -1.0], [1.0, -b]))
    # e = -c x;  u = (k1 + k2) e - k2 before
    step = np.block([[f - (k1 + k2) * g @ c, -k2 * g], [-c, np.zeros((1, 1))]])
    return np.abs(np.linalg.eigvals(step)).max()


def response(drive):
    """G on the upper half of the unit circle, and z."""
    k0, a, b = drive[:3]
    z = np.exp(1j * np.linspace(0.01, np.pi, 2001))
    return k0 * (z + a) / ((z - 1) * (z - b)), z


@pytest.mark.parametrize("ratio", [0.001, 0.03, 10 / 55, 1.0, 7.0, 50.0])
def test_discrete_drive_is_scipys(ratio):
    k0, a, b, *_ = stable_range(28.3, TAU, ratio * TAU)
    above, below, _ = signal.cont2discrete(([28.3], [TAU, 1.0, 0.0]), ratio * TAU, method="zoh")
    # SciPy subtracts numbers that almost agree where T/tau is small.
    np.testing.assert_allclose([k0, k0 * a], above[0, 1:], rtol=1e-9)
    np.testing.assert_allclose([1.0, -1.0 - b, b], below, rtol=1e-12, atol=1e-15)
    assert 0 < b < a < 1


def test_independent_values_of_the_published_drive():
    assert DRIVE[:3] == pytest.approx((0.0242364, 0.941208, 0.833753), abs=5e-7)
    limit = DRIVE.k1_printed
    assert limit == pytest.approx(9.0364, abs=5e-5)
    shares = limit * np.array([0.3, 0.5, 0.7, 0.9])
    wanted = [9.412, 8.997, 5.895, 3.143, 0.952]
    np.testing.assert_allclose(DRIVE.k2_printed([1.52, *shares]), wanted, atol=5e-4)


drives = st.builds(
    lambda gain, tau, ratio: stable_range(gain, tau, ratio * tau),
    st.floats(0.1, 1000.0),
    st.floats(0.001, 10.0),
    st.floats(0.02, 20.0),
)


@settings(max_examples=30, deadline=None)
@given(drives, st.floats(0.01, 0.99))
def test_bounds_are_the_extrema_of_the_printed_conditions(drive, share):
    """Never on the wrong side of a fine grid of the printed formulas, and touching it."""
    limit = drive.k1_printed
    assert 1.0 / limit == pytest.approx(printed_21(drive).max(), rel=1e-6)
    k1 = share * limit
    bound = float(drive.k2_printed(k1))
    g, h = printed_22(drive, k1)
    room = h - bound * g
    scale = np.abs(h).max()
    assert room.min() >= -1e-12 * scale
    nearest = np.argmin(np.where(g > 0, h / np.where(g > 0, g, 1.0), np.inf))
    between = X[[max(nearest - 1, 0), min(nearest + 1, len(X) - 1)]]  # where the minimum lies
    g, h = printed_22(drive, k1, np.linspace(*between, 10_001))
    assert bound == pytest.approx((h[g > 0] / g[g > 0]).min(), rel=1e-5)
    assert bound > 0


def test_multiplied_out_the_theorem_gives_the_printed_cubic_but_another_real_part():
    """(1/K_1 + Re G_11)(1/K_2 + Re G_22) > |G_12 + conj G_21|^2/4 on the unit circle."""
    g, z = response(DRIVE)
    _, a, b = DRIVE[:3]
    x, k1, k2 = z.real, 1.5, 4.0
    other = (1 - 1 / z) * g
    weight = 2 * (1 - x) * (1 + b**2 - 2 * b * x)
    wanted = (1 / k1 + g.real) * (1 / k2 + other.real) - np.abs(g + other.conj()) ** 2 / 4
    cubic, quadratic = (np.interp(x, X, side) for side in printed_22(DRIVE, k1))
    # The printed quadratic is too large by the wrong sign in (1 + a)(1 - b) - (1 - a)(1 + b).
    excess = 4 * DRIVE.k0 * k1 * 2 * (a - b) * x
    found = (quadratic - excess - k2 * cubic) / (4 * k1 * k2 * weight)
    np.testing.assert_allclose(found, wanted, rtol=1e-5, atol=1e-6 * np.abs(wanted).max())
    assert wanted[0] < 0  # near z = 1 the condition fails for every K_2 > 0


@pytest.mark.parametrize("drive", [DRIVE, FASTER])
def test_printed_bound_lies_beyond_the_linear_limit(drive):
    """Eq. 21 is not sufficient as printed: a loop of linear gains inside it is unstable."""
    limit = drive.k1_linear
    assert largest_pole(drive, 0.999 * limit, 0.0) < 1
    assert largest_pole(drive, limit, 0.0) == pytest.approx(1.0, abs=1e-9)
    assert drive.k1_printed > 1.2 * limit
    assert largest_pole(drive, 0.99 * drive.k1_printed, 0.0) > 1.01


@settings(max_examples=50, deadline=None)
@given(drives, *[st.floats(0.001, 0.999)] * 4)
def test_linear_gains_in_the_sectors_of_the_range_are_stable(drive, p, q, r, s):
    k1 = p * min(drive.k1_printed, drive.k1_linear)
    k2 = q * float(drive.k2_printed(k1))
    assert largest_pole(drive, r * k1, s * k2) < 1
    assert largest_pole(drive, k1, k2) < 1


def grown(k1, k2, steps):
    """Logarithm by which the error grows if K_2 acts only in one half of the (e, de) plane."""
    k0, a, b = DRIVE[:3]
    error, before, command, size = 1.0, 1.0, 0.0, 0.0
    for _ in range(steps):
        change = error - before
        gain = k2 if np.arctan2(6 * change, error) % np.pi < np.pi / 3 else 0.0
        last, command = command, k1 * error + gain * change
        following = (1 + b) * error - b * before - k0 * command - k0 * a * last
        scale = max(abs(error), abs(following))
        size += np.log(scale)
        error, before, command = following / scale, error / scale, command / scale
    return size


def test_the_range_is_no_proof_at_its_very_end():
    """A K_2 that comes and goes with the state is worse there than a constant one."""
    found = stable_range(28.3, TAU, T)
    assert found.contains(7.27, 1.94)
    assert largest_pole(DRIVE, 7.27, 1.94) < 1
    assert grown(7.27, 1.94, 20_000) > 10
    assert grown(6.5, 1.94, 20_000) < -100


def test_range_answers_for_points():
    found = stable_range(28.3, TAU, T)
    assert found == DRIVE
    assert found.k1_bound == pytest.approx(7.28786, abs=5e-6)  # (1 - b)/(a K_0)
    assert found.contains(32 / 21, 16 / 3)
    assert found.contains(1.52, 9.41)
    assert not found.contains(1.52, 9.42)
    assert not found.contains(8.0, 0.5)  # inside the printed range only
    assert float(DRIVE.k2_printed(8.0)) > 0.5
    for k1, k2 in [(0, 1), (-1, 1), (1, -1), (np.nan, 1), (1, np.nan), (np.inf, 1), (1, np.inf)]:
        assert not found.contains(k1, k2)
    np.testing.assert_array_equal(found.k2([8.0, 20.0]), [0.0, 0.0])


@settings(max_examples=100, deadline=None)
@given(*[st.floats() | st.sampled_from([0.0, 28.3, 0.055, 0.01, 1e-320, 1e300])] * 3)
def test_any_numbers_give_a_range_or_one_line(gain, time_constant, sample_time):
    try:
        found = stable_range(gain, time_constant, sample_time)
    except UserError as error:
        assert "\n" not in str(error)
        assert "must" in str(error)
    else:
        assert 0 < found.k1_bound < np.inf
        assert 0 <= float(found.k2(found.k1_bound / 2)) < np.inf


@pytest.mark.parametrize(
    ("values", "where"),
    [
        ((0.0, TAU, T), "gain"),
        ((28.3, TAU, np.nan), "sample time"),
        ((28.3, TAU, 10.0), "sample time / time constant"),
    ],
)
def test_values_that_no_drive_has(values, where):
    with refused() as found:
        stable_range(*values)
    assert found.where == where


@pytest.mark.parametrize(("every", "tau"), [(2.1e-5, 0.021), (0.45, 0.009), (0.001, 1.0)])
def test_a_ratio_just_at_an_end_is_within(every, tau):
    """2.1e-5 / 0.021 is less than 0.001 by its last bit."""
    bounds = [stable_range(28.3, tau, x).k1_bound for (x,) in shaken(every)]
    np.testing.assert_allclose(bounds, bounds[0], rtol=1e-9)


def test_stability_and_sectors_do_not_import_jax():
    code = (
        "import sys, hfc_design.stability.stable_range, hfc_design.stability.sectors;"
        "print('jax' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"


@settings(max_examples=50, deadline=None)
@given(drives)
def test_theorem_k1_is_where_the_frequency_response_says(drive):
    k0, a, b = drive[:3]
    z = np.exp(1j * np.logspace(-4, np.log10(np.pi), 4001))
    real = (k0 * (z + a) / ((z - 1) * (z - b))).real
    assert drive.k1_theorem == pytest.approx(-1 / real.min(), rel=1e-4)
    assert drive.k1_theorem < drive.k1_linear


@pytest.mark.parametrize("k1", [0.0, -1.0, np.nan, np.inf, [1.0, -2.0]])
def test_k2_at_no_k1(k1):
    assert np.ravel(DRIVE.k2_printed(k1))[-1] == np.ravel(DRIVE.k2(k1))[-1] == 0.0
