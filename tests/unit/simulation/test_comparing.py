"""Designs side by side: counts and ratios by hand."""

import numpy as np
import pytest
from shaken import shaken
from wording import refused

from hfc_design.core.statistics import share_interval
from hfc_design.files.named_scenario import load_scenario
from hfc_design.simulation.comparison import (
    DesignStatistics,
    MotionComparison,
    _differences,
    compare,
)

ERROR = "rms_error_rad"
TWO = ["pd-only", "lin-lee-1999-table-1"]


def side(values, stable=None, nominal=1.0):
    values = np.array(values, float)
    stable = np.ones(len(values), bool) if stable is None else np.array(stable, bool)
    return DesignStatistics(stable, True, {ERROR: nominal}, {ERROR: values})


def difference(first, second):
    sides = {"a": first, "b": second}
    (found,) = _differences([MotionComparison("m", None, sides, {}, {ERROR: "error [rad]"})])
    return found


def test_a_difference_by_hand():
    a = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]
    b = [2.0, 2.0, 1.0, 8.0, 20.0, 36.0, 49.0, 80.0]
    found = difference(side(a), side(b))
    # The ratios are 1/2, 1, 3, 1/2, 1/4, 1/6, 1/7, 1/10.
    assert (found.better, found.worse, found.both, found.machines) == (6, 1, 8, 8)
    assert found.ratio == pytest.approx(np.sqrt(0.25 * 0.5))
    assert found.ratio_interval == pytest.approx((0.1, 3.0))  # of eight: the first and the last
    assert found.better_interval == share_interval(6, 8)
    # The ranks of the logarithms 1 (no sign), 2.5, 2.5, +4, 5, 6, 7, 8: of 128 signs those of no
    # rank, of one of the 2.5 and of the 4 have as small a sum.
    assert found.p == 2 * 4 / 128
    assert found.p_holm == found.p  # of one alone


def test_who_does_not_keep_a_machine_has_lost_there_whatever_its_number():
    stable = [True] * 6 + [False] * 2
    a = side([1.0] * 8, stable)
    b = side([2.0] * 8, [True] * 7 + [False])
    found = difference(a, b)
    assert (found.both, found.only_first, found.only_second, found.neither) == (6, 0, 1, 1)
    assert (found.better, found.worse, found.machines) == (6, 1, 8)
    assert found.ratio == 0.5
    assert found.ratio_interval == (0.5, np.inf)
    mirrored = difference(b, a)
    assert (mirrored.better, mirrored.worse) == (1, 6)
    assert mirrored.p == found.p
    assert mirrored.ratio == 2.0


def test_one_that_keeps_none_is_infinitely_worse():
    found = difference(side([1.0] * 6, [False] * 6), side([9.0] * 6))
    assert (found.better, found.worse, found.ratio) == (0, 6, np.inf)
    assert found.numbers()["ratio"] is None
    neither = difference(side([1.0] * 6, [False] * 6), side([9.0] * 6, [False] * 6))
    assert np.isnan(neither.ratio)
    assert (neither.p, neither.neither) == (1.0, 6)


def test_no_number_is_worse_than_any_and_like_another_none():
    found = difference(side([np.nan, 1.0, np.nan]), side([5.0, np.nan, np.nan]))
    assert (found.better, found.worse) == (1, 1)
    zero = difference(side([0.0, 0.0]), side([0.0, 1.0]))
    assert (zero.better, zero.worse) == (1, 0)


def test_quantiles_count_what_is_not_stable_last():
    some = side([5.0, 1.0, 4.0, 2.0, 3.0], [True, False, True, True, True])
    assert some.quantile(ERROR, 0.5) == 4.0  # 2 3 4 5 and a failure
    assert some.quantile(ERROR, 0.95) is None
    scores = DesignStatistics(
        np.ones(4, bool), True, {}, {"fitness": np.array([1.0, 2.0, 3.0, 4.0])}
    )
    assert scores.quantile("fitness", 0.75) == 2.0  # three of four have it or more


@pytest.mark.parametrize(
    ("designs", "options"),
    [
        (["pd-only"], {}),
        ([], {}),
        (TWO, {"machines": 0}),
        (TWO, {"scenarios": ["c-axis-ramp"] * 2}),
        (TWO, {"spread": 2.0}),
    ],
)
def test_bad_input_is_one_line(designs, options):
    with refused() as found:
        compare(designs, **options)
    assert "\n" not in found.refusal


def test_two_that_differ_by_rounding_alone_are_equal():
    """The same law written otherwise is neither better nor worse on every machine."""
    given = np.linspace(0.1, 0.9, 40)
    (_, *others) = (np.array(x) for x in shaken(*given))
    for other in others:
        found = difference(side(given), side(other))
        assert (found.better, found.worse, found.p, found.ratio) == (0, 0, 1.0, 1.0)


def test_what_the_fitness_tolerates_is_compared():
    fitness = {"kind": "tolerances", "tolerances": {"chatter": 1.0, "settled_rms_error": 1e-3}}
    scenario = load_scenario("c-axis-ramp", {"fitness": fitness})
    keys = ["fitness", ERROR, "iae_rad_s", "settled_rms_error_rad", "chatter_V"]
    bout = MotionComparison("m", scenario, {}, {}, dict.fromkeys(keys, ""))
    assert bout.compared() == [ERROR, "settled_rms_error_rad", "chatter_V"]
    assert bout._replace(scenario=load_scenario("c-axis-ramp")).compared() == [ERROR]


def test_a_signed_error_of_the_nominal_machine_is_a_magnitude_as_those_of_all():
    far = DesignStatistics(
        np.array([True]), True, {"final_error_mm": -0.163}, {"final_error_mm": [-0.2]}
    )
    assert far.of_nominal("final_error_mm") == 0.163
    assert far.numbers()["metrics"]["final_error_mm"]["median"] == 0.2
    assert (
        DesignStatistics(np.array([True]), True, {"fitness": -2.0}, {}).of_nominal("fitness")
        == -2.0
    )
