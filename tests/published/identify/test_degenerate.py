"""Fits that tell little: slopes that are lost, alike or not finite, values at 0, bounds."""

from dataclasses import replace

import numpy as np
import pytest
from carts import CART, Cart, cart_fit, driven, forced, noisy
from scipy.optimize import minimize_scalar

from hfc_design.identify.identifiability import BOUND, at_bound, certainty, hold_untold

STEPS = 800
NOISE = 2e-4  # [m]


@pytest.mark.parametrize("start", [0.0, -3.0])
def test_a_pull_that_begins_at_0_or_below_and_ends_near_0(start):
    """Alone: the straight line of least squares, with its error; the log tells it, though it is 0.

    As a share of itself it is known badly, as a share of where it began well.
    """
    true = Cart(pull=0.002)
    force = forced(STEPS)
    place = noisy(driven(true, force), NOISE, 4)
    one = cart_fit(["pull"], place, force, {"pull": start})
    columns = np.stack([-driven(true._replace(force_gain=0.0, pull=-1.0), force), np.ones(STEPS)])
    (value, _), (squares,), *_ = np.linalg.lstsq(
        columns.T, place - driven(true._replace(pull=0.0), force)
    )
    error = np.sqrt(np.linalg.inv(columns @ columns.T)[0, 0] * squares / (STEPS - 2))
    known = certainty(one)
    assert known.value[0] == pytest.approx(value, abs=0.01 * error)
    half = 0.5 * (known.high[0] - known.low[0]) / np.sqrt(known.inflated[0])
    assert half == pytest.approx(1.96 * error, rel=0.02)
    assert known.identifiable.all()
    assert hold_untold(one, known)[1].state == ("yes",)


def test_a_machine_that_cannot_be_is_not_found():
    """A cart whose friction may not be below 2.5 / s times its mass, in a log of one of 2.3 / s."""
    true = Cart(mass=2.6, viscous_friction=6.0)

    def fault(changes):
        p = Cart(**changes)
        return "too little friction" if p.viscous_friction < 2.5 * p.mass else CART.fault(changes)

    force = forced(400)
    place = noisy(driven(true, force), NOISE, 4)
    start = {"mass": 2.0, "viscous_friction": 8.0}
    one = cart_fit(
        ["mass", "viscous_friction"], place, force, start, drive=replace(CART, fault=fault)
    )
    assert fault(dict(zip(one.free.names, one.values, strict=True)))
    known = certainty(one)
    inside, edge = at_bound(one, known)
    values = inside.values
    assert edge.sum() == 1
    assert values[1] / values[0] == pytest.approx(2.5, rel=0.01)
    assert fault(dict(zip(one.free.names, values, strict=True))) is None

    def off(mass):  # the best cart along the bound, by SciPy
        left = place - driven(Cart(mass, 2.5 * mass), force)
        return np.std(left)

    best = minimize_scalar(off, bounds=(1.0, 5.0), method="bounded").fun
    assert inside.rms[0] < 1.5 * best
    _, known, note = hold_untold(one, known)
    k = int(np.argmax(edge))
    assert known.state[k] == BOUND
    assert np.isnan([known.low[k], known.high[k]]).all()
    assert note.startswith(f"{one.free.names[k]}: at its lowest or highest")
