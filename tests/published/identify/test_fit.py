"""What is found in logs of a cart, against least squares by NumPy and SciPy on its closed form."""

import numpy as np
import pytest
from carts import CART, Cart, cart_fit, driven, forced, noisy, recorded
from scipy.optimize import minimize_scalar

from hfc_design.identify.fit import by_command
from hfc_design.identify.identifiability import certainty
from hfc_design.identify.parameters import free_parameters
from hfc_design.identify.profiles import LIMIT, profiles

TRUE = Cart(mass=2.6, viscous_friction=6.0, force_gain=1.3, pull=-0.4)
NOISE = 2e-4  # [m]
STEPS = 800
FEW, MUCH = 400, 4e-3  # samples and noise [m], so short and so noisy that it is no parabola


def ends_of(profile):
    """Where it has grown worse by ``LIMIT``; between places the root of it is taken for a line."""
    middle, root = len(profile.values) // 2, np.sqrt(profile.worse)
    left, right = slice(middle, None, -1), slice(middle, None)
    return [np.interp(np.sqrt(LIMIT), root[side], profile.values[side]) for side in (left, right)]


def white(fit):
    """Standard errors of the values under white noise, the delay looked for too."""
    return deviations(fit) / np.sqrt(certainty(fit).inflated[:-2])


def deviations(fit):
    """Standard errors of the values; where a sign is not known they are shares of the start."""
    known = certainty(fit)
    return known.error * np.maximum(np.abs(known.value), (1 - fit.free.positive) * fit.free.scale)


def test_where_the_position_is_linear_it_is_linear_least_squares():
    """Of force_gain and pull, of the samples by which the command is late, and of the zero."""
    force = forced(STEPS)
    place = noisy(driven(TRUE, force), NOISE, 1)
    unit = TRUE._replace(force_gain=1.0, pull=0.0)
    by_gain = driven(unit, force)
    by_pull = -driven(unit, np.ones(STEPS))
    by_delay = TRUE.force_gain * driven(unit, np.r_[0.0, force[:-1] - force[1:]])
    columns = np.stack([by_gain, by_pull, by_delay, np.ones(STEPS)], axis=1)
    values, (squares,), *_ = np.linalg.lstsq(columns, place, rcond=None)
    errors = np.sqrt(np.diag(np.linalg.inv(columns.T @ columns)) * squares / (STEPS - 4))
    held = {name: getattr(TRUE, name) for name in ("mass", "viscous_friction")}
    one = cart_fit(["force_gain", "pull"], place, force, held, late=True)
    np.testing.assert_allclose(one.values, values[:2], rtol=2e-4)
    assert one.late == pytest.approx(values[2], abs=0.1 * errors[2])
    np.testing.assert_allclose(white(one), errors[:2], rtol=0.02)
    assert one.rms[0] == pytest.approx(np.sqrt(squares / STEPS), rel=1e-4)
    for profile in profiles(one, certainty(one)):  # a parabola, as every linear one
        k = one.free.names.index(profile.name)
        error = deviations(one)[k]
        middle = profile.values[len(profile.values) // 2]
        distance = (profile.values - middle) / error
        np.testing.assert_allclose(profile.worse, distance**2, rtol=0.03, atol=1e-3)
        low, high = ends_of(profile)
        assert (high - low) / error == pytest.approx(2 * 1.96, rel=0.03)


def test_bad_starts_end_at_the_same_place():
    """A mass that is begun with at a twentieth."""
    force = forced(FEW)
    wanted = free_parameters(CART, TRUE._asdict() | {"mass": 0.13}, ["mass", "viscous_friction"])
    told = recorded(noisy(driven(TRUE, force), 0.1 * NOISE, 3), force)
    one = by_command(wanted, told, 1, [0.0], 0)
    assert one.values[0] == pytest.approx(2.6, rel=1e-3)


def test_a_profile_is_that_of_a_grid():
    true = Cart(mass=2.6, viscous_friction=6.0)
    force = forced(FEW)
    place = noisy(driven(true, force), MUCH, 8)
    one = cart_fit(["mass", "viscous_friction"], place, force)
    known = certainty(one)

    def squares(mass, friction):
        return FEW * np.var(place - driven(Cart(mass, friction), force))  # its zero is unknown

    def least(mass):
        bounds = np.log([0.01, 100.0])
        best = minimize_scalar(
            lambda x: squares(mass, np.exp(x)), bounds=bounds, method="bounded",
            options={"xatol": 1e-9},
        )  # fmt: skip
        return best.fun

    (profile,) = [own for own in profiles(one, known) if own.name == "mass"]
    middle = len(profile.values) // 2
    floor = least(profile.values[middle])
    grid = np.array([FEW * (least(x) - floor) / floor for x in profile.values])
    grid /= known.inflated[0]
    np.testing.assert_allclose(profile.worse, grid, rtol=0.01, atol=1e-3)
    k = one.free.names.index("mass")
    ends = np.interp([known.low[k], known.high[k]], *profile.supposed)
    assert ends == pytest.approx(LIMIT, rel=2e-3)  # straight lines between 61 points
    sides = profile.worse[[0, -1]]
    assert sides.max() / sides.min() > 1.02  # no parabola in the logarithm of the mass
    for end in ends_of(profile):
        assert FEW * (least(end) - floor) / floor / known.inflated[0] == pytest.approx(
            LIMIT, rel=0.05
        )
