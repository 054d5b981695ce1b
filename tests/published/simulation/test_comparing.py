"""Designs side by side: machines and numbers against single runs, counts and ratios by hand."""

import numpy as np
import pytest

from hfc_design.files.named_scenario import load_scenario
from hfc_design.simulation.comparing import compare
from hfc_design.simulation.comparison import Side
from hfc_design.simulation.evaluating import evaluate
from hfc_design.simulation.monte_carlo import robustness

SHORT = {"simulation.duration_s": 0.3}
ERROR = "rms_error_rad"


@pytest.fixture(scope="module")
def found():
    scenarios = [load_scenario(name, SHORT) for name in ("c-axis-ramp", "c-axis-ramp-cutting")]
    told = []
    designs = ["lin-lee-1999-table-1", "pd-only"]
    result = compare(designs, scenarios, 0.2, 7, 3, lambda *news: told.append(news))
    return result, scenarios, told


def test_each_design_does_what_it_does_alone(found):
    comparison, scenarios, _ = found
    for bout, scenario in zip(comparison.bouts, scenarios, strict=False):
        machines = [one.machines.true for one in bout.found.values()]
        for a, b in zip(*machines, strict=True):
            np.testing.assert_array_equal(a, b)
        for name, side in bout.sides.items():
            alone = robustness(name, scenario, 0.2, 7, 3)
            np.testing.assert_array_equal(side.values[ERROR], alone.values[ERROR])
            np.testing.assert_array_equal(side.stable, alone.stable)
            assert side.nominal[ERROR] == evaluate(name, scenario).metrics[ERROR]
            motion = bout.found[name].motion
            error = motion.axes[0].motion.error
            assert np.sqrt(np.mean(error**2)) == pytest.approx(side.nominal[ERROR])


def test_other_machines_than_those_of_the_scenario_are_said():
    own = {**SHORT, "robust": {"spread": 0.1, "tolerances": {"stiffness": 0.3}}}
    scenario = load_scenario("c-axis-ramp", own)
    designs = ["lin-lee-1999-table-1", "pd-only"]
    found = compare(designs, scenario, 0.2, 2)
    robust = "which are within ±10 %, stiffness ±30 %"
    assert found.notes == [f"other machines than those of [robust] of c-axis-ramp, {robust}"]
    assert compare(designs, scenario, 0.1, 2, tolerances={"stiffness": 0.3}).notes == []


def test_a_motion_that_the_simulation_cuts_short_is_said():
    scenario = load_scenario("milling-table-circle", {"simulation.duration_s": 0.6})
    found = compare(["huang-pid", "huang-cross-coupled"], scenario, 0.1, 1)
    assert found.notes[0].startswith("milling-table-circle: the simulation ends after 0.6 s of a ")


def side(values, stable=None, nominal=1.0):
    values = np.array(values, float)
    stable = np.ones(len(values), bool) if stable is None else np.array(stable, bool)
    return Side(stable, True, {ERROR: nominal}, {ERROR: values})
