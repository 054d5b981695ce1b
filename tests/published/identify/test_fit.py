"""What is found in logs of a cart, against least squares by NumPy and SciPy on its closed form."""

import jax
import numpy as np
import pytest
from carts import CART, Cart, driven, forced, recorded
from scipy.optimize import curve_fit

from hfc_design.identify.certainty import certainty
from hfc_design.identify.fit import Problem, fitted, settled
from hfc_design.identify.free import free
from hfc_design.identify.profile import profiles
from hfc_design.identify.replay import replay
from hfc_design.identify.search import Found, by_command

TRUE = Cart(mass=2.6, viscous_friction=6.0, force_gain=1.3, pull=-0.4)
NOISE = 2e-4  # [m]
STEPS = 800


def noisy(seed=1):
    """(steps,) white."""
    return np.random.default_rng(seed).normal(0.0, NOISE, STEPS)


def found(names, place, force, bandwidth=0.0, late=True):
    """The fit by one start, that of a machine with twice the mass say."""
    changes = {n: x for n, x in TRUE._asdict().items() if n not in names}
    wanted = free(CART, changes, names)
    residual = replay(wanted, recorded(place, force), bandwidth, 1)
    held = np.append(np.ones(len(names)), float(late))
    problem = Problem(wanted, residual, np.array([np.std(place)]), held)
    with jax.enable_x64(True):
        problem, numbers = settled(problem, wanted.begun)
        return Found(fitted(problem, numbers, 1), problem, bandwidth)


def white(fit_found):
    """Standard errors of the values under white noise, the delay looked for too."""
    fit = fit_found.fit
    return deviations(fit) / np.sqrt(certainty(fit).inflated[:-1])


def deviations(fit):
    """Standard errors of the values; where a sign is not known they are shares of the start."""
    known = certainty(fit)
    return known.error * np.maximum(np.abs(known.value), (1 - fit.free.positive) * fit.free.scale)


def test_where_the_position_is_linear_it_is_linear_least_squares():
    """Of force_gain and pull, of the samples by which the command is late, and of the zero."""
    force = forced(STEPS)
    place = driven(TRUE, force) + noisy()
    unit = TRUE._replace(force_gain=1.0, pull=0.0)
    by_gain = driven(unit, force)
    by_pull = -driven(unit, np.ones(STEPS))
    by_delay = TRUE.force_gain * driven(unit, np.r_[0.0, force[:-1] - force[1:]])
    columns = np.stack([by_gain, by_pull, by_delay, np.ones(STEPS)], axis=1)
    values, (squares,), *_ = np.linalg.lstsq(columns, place, rcond=None)
    errors = np.sqrt(np.diag(np.linalg.inv(columns.T @ columns)) * squares / (STEPS - 4))
    one = found(["force_gain", "pull"], place, force)
    np.testing.assert_allclose(one.fit.free.values(one.fit.numbers), values[:2], rtol=2e-4)
    assert one.fit.late == pytest.approx(values[2], abs=0.1 * errors[2])
    np.testing.assert_allclose(white(one), errors[:2], rtol=0.02)
    assert one.fit.rms[0] == pytest.approx(np.sqrt(squares / STEPS), rel=1e-4)
    for profile in profiles(one, certainty(one.fit)):  # a parabola, as every linear one
        k = one.fit.free.names.index(profile.name)
        error = deviations(one.fit)[k]
        middle = profile.values[len(profile.values) // 2]
        distance = (profile.values - middle) / error
        np.testing.assert_allclose(profile.worse, distance**2, rtol=0.03, atol=1e-3)
        low, high = profile.interval
        assert (high - low) / error == pytest.approx(2 * 1.96, rel=0.03)


def test_mass_and_friction_are_those_of_scipy():
    force = forced(STEPS)
    place = driven(TRUE, force) + noisy(2)

    def model(_, mass, friction, zero):
        return zero + driven(TRUE._replace(mass=mass, viscous_friction=friction), force)

    values, covariance = curve_fit(model, np.arange(STEPS), place, p0=(2.0, 8.0, 0.0))
    one = found(["mass", "viscous_friction"], place, force, late=False)
    np.testing.assert_allclose(one.fit.free.values(one.fit.numbers), values[:2], rtol=1e-6)
    np.testing.assert_allclose(white(one), np.sqrt(np.diag(covariance))[:2], rtol=0.01)


def test_bad_starts_end_at_the_same_place():
    """A mass that is begun with at a twentieth."""
    force = forced(STEPS)
    wanted = free(CART, TRUE._asdict() | {"mass": 0.13}, ["mass"])
    told = recorded(driven(TRUE, force) + noisy(3), force)
    one = by_command(wanted, told, 1, [0.0], 0, lambda line: None)
    assert wanted.values(one.fit.numbers)[0] == pytest.approx(2.6, rel=1e-3)
