"""Trajectories of the closed loop against SciPy and a plain-Python program of the same loop."""

import numpy as np
import oracle
import pytest
from lifted import every_axis

from hfc_design.controllers.hierarchical.law import Layout, hierarchical
from hfc_design.files.named_scenario import load_scenario
from hfc_design.simulation import population as simulate
from hfc_design.simulation.closed_loop import closed_loop

HIERARCHICAL = every_axis("pd+hierarchical-fuzzy", hierarchical(Layout(), 0.001))
SECONDS = 1.001  # so that the sample at 1 s is there
LOADS = {"c-axis-ramp": None, "c-axis-ramp-cutting": oracle.cutting_load}


def simulated(scenario, controller, gains, seconds=SECONDS):
    """States (steps, 6, individuals) and commands (steps, individuals)."""
    scenario = load_scenario(scenario, [f"simulation.duration_s={seconds}"])
    loop = closed_loop(scenario, controller)
    machines = simulate.one_machine(scenario.plant.values())
    _, (motion,) = simulate.trajectory(loop, machines, scenario.samples(), gains)
    return np.stack(motion.state, axis=1), motion


def plain(gains, one):
    """What the oracle needs of one individual: nested tree, kp, kd."""
    tree = None
    if hasattr(gains, "sources"):
        sources, tables = gains.sources[..., one].tolist(), gains.consequents[..., one].tolist()
        tree = oracle.nested(len(gains.scales), sources, tables)
    return tree, float(gains.kp[one]), float(gains.kd[one])


@pytest.mark.parametrize("count", [8, pytest.param(24, marks=pytest.mark.slow)])
@pytest.mark.parametrize("scenario", LOADS)
def test_loop_is_plain_rk4_to_rounding(scenario, count, random_population):
    gains = random_population(count, seed=6)
    states, motion = simulated(scenario, HIERARCHICAL, gains)
    for one in range(count):
        exact, commands = oracle.closed_loop(*plain(gains, one), 1.0, LOADS[scenario], "RK4")
        error = abs(states[..., one] - exact) / abs(exact).max(axis=0)
        assert error.max() < 1e-8
        assert abs(motion.command[:-1, one] - commands).max() < 1e-7
