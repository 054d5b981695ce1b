"""Designs side by side: machines and numbers against single runs."""

import numpy as np
import pytest
from wording import refused

from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.simulation.comparison import EVERY, _together, compare
from hfc_design.simulation.evaluating import evaluate
from hfc_design.simulation.monte_carlo import robustness

SHORT = {"simulation.duration_s": 0.5}
ERROR = "rms_error_rad"
DESIGNS = {
    "calm": load_design("pd-only", ["controller.pd.kp=500.0"]),
    "pd-only": load_design("pd-only"),
}


@pytest.fixture(scope="module")
def found():
    scenarios = [load_scenario(name, SHORT) for name in ("c-axis-ramp", "c-axis-ramp-cutting")]
    told = []
    result = compare(DESIGNS, scenarios, 0.1, 11, 3, lambda *news: told.append(news))
    return result, scenarios, told


def test_all_motions_are_as_one_after_the_other(found):
    comparison, *_ = found
    one, other, every = comparison.bouts
    assert every.name == EVERY
    for name, side in every.sides.items():
        squares = one.sides[name].values[ERROR] ** 2 + other.sides[name].values[ERROR] ** 2
        np.testing.assert_allclose(side.values[ERROR], np.sqrt(squares / 2))  # of the same length


def test_each_design_does_what_it_does_alone(found):
    comparison, scenarios, _ = found
    for bout, scenario in zip(comparison.bouts, scenarios, strict=False):
        machines = [one.machines.actual for one in bout.results.values()]
        for a, b in zip(*machines, strict=True):
            np.testing.assert_array_equal(a, b)
        for name, side in bout.sides.items():
            alone = robustness(DESIGNS[name], scenario, 0.1, 11, 3)
            np.testing.assert_array_equal(side.values[ERROR], alone.values[ERROR])
            np.testing.assert_array_equal(side.stable, alone.stable)
            assert side.nominal[ERROR] == evaluate(DESIGNS[name], scenario).metrics[ERROR]
            motion = bout.results[name].motion
            error = motion.axes[0].motion.error
            assert np.sqrt(np.mean(error**2)) == pytest.approx(side.nominal[ERROR])


def test_a_motion_or_metric_that_there_is_not(found):
    comparison, *_ = found
    assert comparison.of("c-axis-ramp", ERROR)
    for motion, metric, where in (
        ("c-axis-ramp", "iae_rad_s", "metric 'iae_rad_s'"),
        ("c-axis-rmp", ERROR, "motion 'c-axis-rmp'"),
        ("c-axis-ramp", "rms_eror_rad", "metric 'rms_eror_rad'"),
    ):
        with refused() as told:
            comparison.of(motion, metric)
        assert told.where == where


def test_different_machines_are_not_taken_together(found):
    one, other, _ = found[0].bouts
    heavier = {
        name: x._replace(
            machines=x.machines._replace(nominal=(x.machines.nominal[0]._replace(poles=3.0),))
        )
        for name, x in other.results.items()
    }
    assert _together([one, other._replace(results=heavier)]) == []
    assert _together([one]) == []


def test_other_machines_than_those_of_the_scenario_are_said():
    own = {**SHORT, "robust": {"spread": 0.1, "tolerances": {"stiffness": 0.3}}}
    scenario = load_scenario("c-axis-ramp", own)
    found = compare(DESIGNS, scenario, 0.2, 11)
    robust = "which has ±10 %, stiffness ±30 %"
    assert found.notes == [f"machines differ from [robust] of c-axis-ramp, {robust}"]
    assert compare(DESIGNS, scenario, 0.1, 11, tolerances={"stiffness": 0.3}).notes == []
    alike = compare(DESIGNS, scenario, machines=11)  # as nothing else is asked
    assert alike.notes == []
    assert (alike.spread, alike.tolerances) == (0.1, {"stiffness": 0.3})
    (bout,) = alike.bouts
    (drawn,) = bout.results[next(iter(DESIGNS))].machines.actual
    assert 0.1 < np.abs(drawn.stiffness / drawn.stiffness[0] - 1.0).max() < 0.3
