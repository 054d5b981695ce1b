"""The bound: against programmes formed by hand, SciPy's integrator, and motions that exist."""

import numpy as np
import pytest
from scipy.optimize import linprog

from hfc_design.attainable.certificate import Bounds, certified
from hfc_design.attainable.linear_model import ANGLE, linear_model, sampled
from hfc_design.attainable.linear_program import Linear, linear_program
from plants.c_axis import CAxisParameters

MACHINE = linear_model(CAxisParameters())


def test_any_multipliers_prove_no_more_than_the_programme_and_the_best_ones_as_much():
    """A dense programme of six samples, by columns of answers instead of states."""
    time, steps = 0.02, 6
    one = sampled(MACHINE, time)
    errors = 1e-4 * np.array([1.0, 2.0, 4.0, 6.0, 9.0, 12.0])
    voltage = np.full(steps, 3.0)
    zeros = np.zeros(steps)
    answers = np.zeros((steps, steps))
    for j in range(steps):
        x = one.voltage
        for k in range(j, steps):
            answers[k, j] = x[ANGLE]
            x = one.a @ x
    eye = np.eye(steps)
    primal = linprog(
        [*zeros, *np.ones(2 * steps)],
        A_eq=np.hstack([answers, eye, -eye]),
        b_eq=errors,
        bounds=[(-3.0, 3.0)] * steps + [(0.0, None)] * 2 * steps,
    )
    system = Linear(np.array([one.a] * steps), np.array([one.voltage[:, None]] * steps), ANGLE)
    found = linear_program(system, errors, -voltage[:, None], voltage[:, None]).least_sum()
    assert np.abs(found.errors).sum() == pytest.approx(primal.fun, rel=1e-6)
    bounds = Bounds(voltage, zeros, zeros)
    best = certified(MACHINE, one, errors, np.clip(found.multipliers, -1, 1), bounds)
    assert best.bound == pytest.approx(primal.fun, rel=1e-6)
    assert best.bound <= primal.fun
    random = np.random.default_rng(0).uniform(-1, 1, (60, steps))
    for multipliers in [*random, *np.sign(random), np.zeros(steps)]:
        assert certified(MACHINE, one, errors, multipliers, bounds).bound <= primal.fun


def test_what_bristles_take_away_is_no_less_than_any_that_are_tried():
    """Bristles of a hundred pieces a sample, the worst by hand: nearly as much, never more."""
    time, steps, pieces = 0.002, 8, 100
    one, fine = sampled(MACHINE, time), sampled(MACHINE, time / pieces)
    multipliers = np.array([1.0, -1.0, 1.0, 0.5, -0.2, 1.0, -1.0, 0.3])
    low, high = -7e-5 * np.linspace(0.1, 1.0, steps), 5e-5 * np.linspace(0.0, 1.0, steps)
    proof = certified(
        MACHINE, one, np.zeros(steps), multipliers, Bounds(np.zeros(steps), low, high)
    )
    back, taken = np.zeros(5), 0.0
    for k in range(steps - 1, -1, -1):
        back[ANGLE] += multipliers[k]
        for _ in range(pieces):
            by = back @ fine.bristle
            taken += max(by * low[k], by * high[k])
            back = back @ fine.a
    assert proof.bound <= -taken
    assert proof.bound == pytest.approx(-taken, rel=5e-3)
