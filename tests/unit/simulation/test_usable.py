"""Whether a loop is stable and can be used: the rules, against numbers by hand."""

import numpy as np
import pytest

import hfc_design.api as hfc
from hfc_design.files.named_scenario import load_scenario
from hfc_design.objectives.judge import Judged
from hfc_design.simulation.acceptance import motion_result, units
from hfc_design.simulation.divergence import divergence_of, finer
from hfc_design.simulation.repeats import Repeats, averaged
from hfc_design.simulation.stability_criteria import STABILITY, instabilities
from hfc_design.simulation.usable import gain_range


def test_the_range_of_gains_is_that_of_a_threshold():
    found = gain_range(lambda factors: np.append(1.0, factors) * 3.0 < 10.0)
    assert found[1] == pytest.approx(10.0 / 3.0, rel=3e-3)
    assert found[0] == pytest.approx(16.0 ** (-31 / 32))
    assert gain_range(lambda factors: np.append(1.0, factors) > 1.5) is None


SHORT = ["simulation.duration_s=3"]


def settled(measured, failed, motions):
    """(machines, motions) for which there is no reason why it should not be stable."""
    return ~np.logical_or.reduce([*instabilities(measured, failed, motions).values()])


def test_the_rule_by_hand():
    ramp = load_scenario("c-axis-ramp", [*SHORT, "reference.velocity=0.03"])  # to 90 mrad
    good = [0.0, 0.0, 1e-3]
    rows = {
        "nominal": (good, True),
        "within 5 % of the way": ([0.0, 0.0, 4.49e-3], True),
        "beyond it": ([0.0, 0.0, 4.51e-3], False),
        "converges": ([0.3, 0.1, 1e-3], True),
        "oscillates": ([0.301, 0.0, 1e-3], False),
        "held by its limit": ([0.0, 0.101, 1e-3], False),
        "no number": ([np.nan, 0.0, 1e-3], False),
    }

    def judged(*values, where=ramp):
        measured = np.array([*values])[:, None, :]
        return settled(measured, np.zeros(measured.shape[:2], bool), [where])[:, 0].tolist()

    assert judged(*(row for row, _ in rows.values())) == [told for _, told in rows.values()]
    assert settled(np.array([[good]]), np.array([[True]]), [ramp]).tolist() == [[False]]
    # Three times the nominal one where that is more, if the nominal one settles.
    assert judged([0, 0, 20e-3], [0, 0, 59e-3], [0, 0, 61e-3]) == [True, True, False]
    assert judged([1, 0, 20e-3], [0, 0, 59e-3], [0, 0, 4e-3]) == [False, False, True]
    assert judged([0, 0, 80e-3], [0, 0, 0.0899], [0, 0, 0.091]) == [True, True, False]
    assert judged([0, 0, 0.091]) == [False]
    told = load_scenario(ramp, {"constraints.late_error": "2 mrad"})
    assert judged([0, 0, 1e-4], [0, 0, 1.9e-3], [0, 0, 2.1e-3], where=told) == [True, True, False]
    still = load_scenario(ramp, {"reference.velocity": 0.0})
    assert judged([0, 0, 5.0], [0, 0, 16.0], [0.4, 0, 0.0], where=still) == [True, True, False]


def test_costs_of_motions_are_averaged_and_failures_stay():
    merits = np.array([[1.0, 3.0], [0.0, 3.0], [-1.0, 3.0], [2.0, -np.inf]])
    assert averaged(merits, np.array([1.0, 3.0])).tolist() == [2.0, 0.0, 0.0, -np.inf]


@pytest.mark.parametrize(
    ("values", "chaotic", "worth"),
    [
        ([100.0, 99.6, 100.4], False, 100.0),
        ([100.0, 99.4, 100.5], True, 99.4),
        ([-100.0, -99.4, -100.5], True, -100.5),
        ([100.0, -np.inf, 100.0], True, -np.inf),
        ([-np.inf, 100.0, 90.0], False, -np.inf),  # it has diverged
    ],
)
def test_chaotic_is_what_differs_by_more_than_a_hundredth(values, chaotic, worth):
    many = Repeats(np.array(values))
    assert many.chaotic is chaotic
    assert many.worth == worth


@pytest.mark.parametrize(("duration", "passes"), [(0.079, False), (0.08, True)])
def test_a_motion_of_fewer_than_80_samples_is_not_passed(duration: float, passes: bool):
    """Ten samples in each half of its last quarter, where all that is measured is 0."""
    scenario = load_scenario("c-axis-ramp", {"simulation.duration_s": duration})
    values = np.zeros((3, 1, len(units(scenario)) + len(STABILITY)))
    still = Judged(np.ones((3, 1)), values, np.zeros((3, 1), bool))
    assert (motion_result(scenario, still, 0, scenario).nominal_reasons == ()) == passes


def test_runaway_is_where_a_quantity_leaves_its_size_for_good():
    time = 0.001 * np.arange(1000)
    spike = np.where(np.arange(1000) == 3, 1e9, 1.0)  # comes back
    late = np.where(time < 0.7, 1.0, 2e3)
    later = np.where(time < 0.8, 1.0, np.nan)
    assert divergence_of(time, {"a": spike, "b": later, "c": late}) == (pytest.approx(0.7), "c")
    assert divergence_of(time, {"a": spike}) == (pytest.approx(1.0), "the fitness")
    grown = np.where(time < 0.8, np.exp(np.maximum(time - 0.795, 0.0) * 1e3), np.nan)
    assert divergence_of(time, {"b": later, "d": grown}).cause == "d"


def test_finer_steps_stop_where_they_are_not_allowed():
    steps = [own.simulation.substeps for own in finer(hfc.load_scenario("c-axis-ramp"))]
    assert steps == [4, 16]
    many = hfc.load_scenario("c-axis-ramp", {"simulation.substeps": 100})
    assert [own.simulation.substeps for own in finer(many)] == [400]
