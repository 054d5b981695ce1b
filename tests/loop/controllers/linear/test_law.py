"""The linear law: by hand, and against SciPy's simulation of a friction-free drive."""

import numpy as np
import pytest
from scipy.linalg import solve_discrete_are
from scipy.signal import cont2discrete, dlsim
from sledge import imported

from hfc_design import api
from hfc_design.controllers.kinds import KINDS


def test_an_optimal_loop_is_that_of_scipy(own):
    """LQR of a mass under viscous friction: the closed loop as SciPy solves and simulates it."""
    api.register(imported("mine").SLEDGE)  # m dv/dt = u - 3 v, m = 2
    every, weights = 0.01, {"error": 300.0, "error_rate": 5.0}
    sledge = (np.array([[0.0, 1.0], [0.0, -1.5]]), np.array([[0.0], [0.5]]), np.eye(2), 0)
    a, b, *_ = cont2discrete(sledge, every)
    cost = np.diag([x**2 for x in weights.values()])
    value = solve_discrete_are(a, b, cost, np.eye(1))
    k = np.linalg.solve(1.0 + b.T @ value @ b, b.T @ value @ a)

    genome = KINDS.get("lqr").genome
    settings = {"kind": "lqr", "ranges": {name: [w, w] for name, w in weights.items()}}
    scenario = api.load_scenario(
        {
            "plant": {"name": "sledge"},
            "reference": {"kind": "step", "height": 1.0},
            "simulation": {"duration_s": 1.0, "sample_time_s": every, "substeps": 8},
            "controller": settings,
        }
    )
    made = genome(scenario.controller, scenario.target)
    record = made.record(made.empty())
    assert (record["kp"], record["kd"]) == pytest.approx(tuple(k[0]), rel=1e-9)

    gains = {name: value for name, value in record.items() if name != "kind"}
    (axis,) = api.evaluate(api.with_gains(scenario, "lqr", gains), scenario).axes
    closed = (a - b @ k, b @ k[:, :1], np.eye(2), np.zeros((2, 1)), every)
    outputs = dlsim(closed, np.ones(100))[1]
    np.testing.assert_allclose(axis.motion.error, 1.0 - outputs[:, 0], atol=1e-9)
