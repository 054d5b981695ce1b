"""Linear laws as rule tables along trees: by hand, by SciPy, and what they are worth at once."""

import numpy as np
import pytest

from hfc_design.controllers.hierarchical.laws import Laws
from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs.individuals import design_with
from hfc_design.runs.problem import Problem
from hfc_design.simulation import population as simulate
from hfc_design.simulation.closed_loop import closed_loop
from hfc_design.simulation.evaluating import evaluate


def test_a_law_in_the_loop_is_a_linear_controller():
    """Without inertia, constant and limit: as an lqr of the same gains in a design file."""
    scenario = load_scenario("c-axis-ramp", ["simulation.duration_s=0.3"])
    problem = Problem(scenario)
    laws = problem.genome.laws()
    numbers = np.array([[900.0, 100.0, 50.0, 5.0, 0.0, 0.0]])
    loop = closed_loop(scenario, laws.controller())
    gains = laws.gains(Laws(np.zeros(1, int), numbers))
    machines = simulate.one_machine(scenario.plant.values())
    judged, _ = simulate.trajectory(loop, machines, scenario.samples(), gains)
    signals = {"deflection": 50.0, "deflection_rate": 5.0}
    record = {"kind": "lqr", "kp": 900.0, "kd": 100.0, "ki": 0.0, "signals": signals}
    ahead = {"velocity": 0.0, "acceleration": 0.0, "coulomb": 0.0, "coulomb_width": 1.0}
    design = design_with({**record, "feed_forward": ahead, "weights": {}}, scenario)
    assert judged.values[0, 0] == pytest.approx(evaluate(design, scenario).fitness, rel=1e-9)
