"""Trajectories of the closed loop against a plain-Python program of the same loop."""

import oracle
import pytest
from populations import HIERARCHICAL, LOADS, plain, simulated


@pytest.mark.parametrize("scenario", LOADS)
def test_loop_is_plain_rk4_to_rounding(scenario, random_population):
    gains = random_population(8, seed=6)
    states, motion = simulated(scenario, HIERARCHICAL, gains)
    for one in range(8):
        exact, commands = oracle.closed_loop(*plain(gains, one), 1.0, LOADS[scenario], "RK4")
        error = abs(states[..., one] - exact) / abs(exact).max(axis=0)
        assert error.max() < 1e-8
        assert abs(motion.command[:-1, one] - commands).max() < 1e-7
