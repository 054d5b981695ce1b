"""Trajectories of the closed loop against SciPy and a what was recorded."""

import json

import numpy as np
import oracle
import pytest
from places import DATA
from populations import HIERARCHICAL, LOADS, plain, simulated

RECORDED = DATA / "c_axis_published_controllers.json"


def compared(found, exact):
    """Asserts that states (steps, 6) agree; the current (up to 17 A) relative to its peak.

    Where the spindle reverses, |omega_c| of eq. 1f has a corner and RK4 loses its order: there
    velocities and current are good to 1e-5, the angles to 1e-7 rad all the same.
    """
    error = np.max(abs(found - exact) / np.maximum(1.0, abs(exact).max(axis=0)), axis=0)
    reverses = exact[:, 4].min() < -1e-5
    assert error[[1, 3, 5]].max() < 1e-7
    assert error.max() < (1e-5 if reverses else 1e-7)
    return reverses


PUBLISHED = {
    "table-1-no-load": ("lin-lee-1999-table-1", "c-axis-ramp"),
    "table-2-cutting-load": ("lin-lee-1999-table-2", "c-axis-ramp-cutting"),
    "pd-only-no-load": ("pd-only", "c-axis-ramp"),
}


@pytest.mark.parametrize("case", PUBLISHED)
def test_published_controllers_move_as_radau_says(case, published):
    design, scenario = PUBLISHED[case]
    controller, gains = published(design)
    states, motion = simulated(scenario, controller, gains)
    exact, commands = oracle.closed_loop(*plain(gains, 0), 1.0, LOADS[scenario], "Radau")
    precision = 5e-5 if compared(states[..., 0], exact) else 2e-6  # [V]
    assert abs(motion.command[:-1, 0] - commands).max() < precision

    recorded = json.loads(RECORDED.read_text())[case]
    rows = np.array([round(sample["time_s"] / 0.001) for sample in recorded["samples"]])
    wanted = np.array([sample["state"] for sample in recorded["samples"]])
    compared(states[rows, :, 0], wanted)
    # The recorded voltage is the one held until that time.
    voltages = [sample["voltage_V"] for sample in recorded["samples"]]
    assert motion.command[rows - 1, 0] == pytest.approx(voltages, abs=precision)
    # The recorded sums run over t = 0 to 0.999 s: the sample at rest counts, the last does not.
    for part, name in (("error", "sum_abs_error"), ("error_rate", "sum_abs_error_rate")):
        total = abs(getattr(motion, part)[:1000]).sum()
        assert total == pytest.approx(recorded[name], rel=5e-7)


@pytest.mark.parametrize(("count", "wanted"), [(8, 4), (32, 20)])
def test_random_controllers_move_as_scipy_says(count, wanted, random_population):
    gains = random_population(count, seed=5)
    states, _ = simulated("c-axis-ramp", HIERARCHICAL, gains)
    smooth = 0
    for one in range(count):
        assert oracle.sliding_poles(oracle.plant(), gains.kp[one], gains.kd[one]).real.max() < -0.4
        exact, _ = oracle.closed_loop(*plain(gains, one), 1.0, None, "DOP853", rtol=1e-12)
        assert abs(exact[:, 3]).max() < 0.08  # 20 V of fuzzy output over kp, and the ramp
        smooth += not compared(states[..., one], exact)
    assert smooth >= wanted
