"""Intervals and what is not told: against exact variances, and combinations known by hand."""

import jax
import numpy as np
import pytest
from carts import CART, Cart, cart_fit, driven, fit_with, forced, noisy, recorded

from hfc_design.core.numbers import digits
from hfc_design.identify.fit import Problem, fitted
from hfc_design.identify.identifiability import certainty, hold_untold
from hfc_design.identify.parameters import free_parameters
from hfc_design.identify.replay import replay
from plants import PLANTS


def cart_found(names, true, start=None, noise=1e-5):
    """The fit of a log of a cart, its delay looked for too."""
    force = forced(400)
    place = noisy(driven(true, force), noise, 3)
    return cart_fit(names, place, force, start, late=True)


def test_what_no_motion_can_tell_is_named():
    """Mass, friction, gain and pull of a cart: all of them by the same factor move it alike."""
    true = Cart(2.4, 7.0, 1.2, 0.6)
    names = ["mass", "viscous_friction", "force_gain", "pull"]
    found = cart_found(names, true)
    known = certainty(found)
    assert not any(known.identifiable)
    worst = known.untold[0]
    assert worst.shares == pytest.approx(dict.fromkeys(names, 1.0), abs=0.02)
    assert "may change by" in worst.line()
    assert len(known.untold) == 1
    # What is told is their ratios.
    values = dict(zip(names, known.value, strict=True))
    assert values["mass"] / values["force_gain"] == pytest.approx(2.0, rel=2e-3)


def test_mass_and_gain_of_the_positioning_stage_are_one_number():
    """The same of a built-in machine, by its slopes alone."""
    stage = PLANTS["positioning-stage"]
    names = ["mass", "viscous_friction", "coulomb_friction", "offset", "amplifier_gain"]
    wanted = free_parameters(stage, {}, names)
    steps = 1000
    command = 2.0 * np.sin(2.0 * np.pi * 2.0 * 1e-3 * np.arange(steps))
    blank = recorded(np.zeros(steps), command)
    with jax.enable_x64(True):
        place = -np.asarray(replay(wanted, blank, 0.0, 1)(wanted.start, 0.0))[:, 0]
        place += np.random.default_rng(2).normal(0.0, 1e-3, steps)
        residual = replay(wanted, recorded(place, command), 20.0, 1)
        moves = np.append(np.ones(len(names) + 1), 0.0)
        problem = Problem(wanted, residual, np.array([1e-3]), moves, 20.0)
        known = certainty(fitted(problem, wanted.begun))
    assert not any(known.identifiable)
    assert known.untold[0].shares == pytest.approx(dict.fromkeys(names, 1.0), abs=0.02)


def test_what_is_given_has_the_interval_that_it_has_where_the_held_one_is_known():
    """The pull is held at 0.5 and is 0.6: all else is found smaller by 5 / 6, as sure as then."""
    names = ["mass", "viscous_friction", "force_gain"]
    true = Cart(2.4, 7.0, 1.2, 0.6)
    found = cart_found([*names, "pull"], true)
    _, known, note = hold_untold(found, certainty(found))
    assert known.state == ("given", "given", "given", "held")
    alone = cart_found(names, true)
    sure = certainty(alone)
    np.testing.assert_allclose(known.value[:3], sure.value, rtol=1e-5)
    np.testing.assert_allclose(sure.value, [2.0, 7.0 / 1.2, 1.0], rtol=5e-3)
    for end in ("low", "high"):
        np.testing.assert_allclose(
            getattr(known, end)[:3] / sure.value - 1.0,
            getattr(sure, end) / sure.value - 1.0,
            rtol=0.01,
        )
    assert note == "fixed at its start value: pull; the log determines others only relative to it"


def test_no_last_bit_decides_which_of_two_is_named_first():
    """Of a log without noise that tells only what a cart's numbers are beside one another."""
    names = ("force_gain", "mass", "viscous_friction")
    wanted, rng = free_parameters(CART, {}, names), np.random.default_rng(4)
    rows, residual = rng.standard_normal((500, 2)), 1e-9 * rng.standard_normal(500)
    slopes = np.concatenate([rows, -rows.sum(axis=1, keepdims=True), 0.0 * rows], axis=1)
    told = set()
    for _ in range(6):
        off = slopes * (1.0 + 1e-12 * rng.uniform(-1.0, 1.0, slopes.shape))
        known = certainty(fit_with(wanted, residual, off, scale=1e-9))
        (one,) = known.untold
        assert one.shares == pytest.approx(dict.fromkeys(names, 1.0))
        told.add((one.line(), *np.argsort(-digits(known.error), kind="stable").tolist()))
    assert len(told) == 1


def test_one_that_is_known_tells_the_others():
    true = Cart(2.4, 7.0, 1.2, 0.6)
    found = cart_found(["mass", "viscous_friction", "force_gain"], true, {"pull": 0.6})
    known = certainty(found)
    assert all(known.identifiable)
    assert known.untold == ()
    assert (known.low < [2.4, 7.0, 1.2]).all()
    assert (known.high > [2.4, 7.0, 1.2]).all()


def test_what_is_given_is_told_beside_one_that_is_not_and_cannot_be_where_it_began():
    """Friction of 3, known to two thirds, that began at 40; gain and pull are held."""
    names = ["mass", "viscous_friction", "force_gain", "pull"]
    start = {"viscous_friction": 40.0}
    found = cart_found(names, Cart(2.4, 3.0, 1.2, 0.6), start, noise=1e-2)
    _, known, note = hold_untold(found, certainty(found))
    assert known.state == ("given", "no", "held", "held")
    assert known.low[0] < 2.4 / 1.2 < known.high[0]
    assert known.value[1] < 10.0
    assert known.value[2:].tolist() == [1.0, 0.5]
    assert "does not determine viscous_friction: as found, since its start value" in note
