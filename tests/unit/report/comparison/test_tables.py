"""What a comparison says: best values, units, words where there is no number, rows of a CSV."""

import numpy as np
import pytest

from hfc_design.plotting.numbers import readable
from hfc_design.report.comparison.tables import metric_rows
from hfc_design.report.comparison.traces import extremes
from hfc_design.simulation.comparison import DesignStatistics, MotionComparison

ERROR = "rms_error_rad"
TOLD = {ERROR: "root mean square of the tracking error [rad]"}


def side(values, stable=None, nominal_stable=True):
    values = np.array(values, float)
    stable = np.ones(len(values), bool) if stable is None else np.array(stable, bool)
    return DesignStatistics(stable, nominal_stable, {ERROR: float(values[0])}, {ERROR: values})


def bout(**sides):
    return MotionComparison("m", None, sides, {}, TOLD)


@pytest.mark.parametrize(
    ("unit", "size", "told"),
    [
        ("rad", 2e-5, (1e6, "µrad")),
        ("rad", 2e-3, (1e3, "mrad")),
        ("rad", 2.0, (1.0, "rad")),
        ("rad/s", 2e-3, (1e3, "mrad/s")),
        ("mm", 0.02, (1e3, "µm")),
        ("BLU", 1e-9, (1.0, "BLU")),
        ("rad", 0.0, (1e6, "µrad")),
    ],
)
def test_numbers_need_no_power_of_ten(unit, size, told):
    assert readable(unit, size) == told


def test_lines_by_hand():
    a = side([2e-4, 1e-4, 3e-4], [True, True, False])
    b = side([5e-4, 5e-4, 4e-4])
    c = side([1e-4, 1e-4, 1e-4], [False] * 3, nominal_stable=False)
    (all_, interval, *others), best = metric_rows(bout(a=a, b=b, c=c))
    assert all_ == ["stable machines [%]", "all", "66.7", "100", "0"]
    assert interval[3] == "29.2–100"  # 0.025 ** (1 / 3)
    assert others == [
        ["rms error [µrad]", "nominal", "200", "500", "unstable"],
        ["", "median", "200", "500", "unstable"],  # of 100 200 and a failure
        ["", "95 %", "unstable", "500", "unstable"],
    ]
    assert best == [[3], [], [2], [2], [3]]


def test_a_chaotic_fitness_is_a_range_and_worse_than_one_above_its_lower_end():
    def scored(value, ranges):
        values = {ERROR: np.ones(2), "fitness": np.full(2, value)}
        return DesignStatistics(
            np.ones(2, bool), True, {ERROR: 1.0, "fitness": value}, values, ranges
        )

    lucky = scored(430.8, {"fitness": {"lowest": 362.0, "highest": 511.0}})
    lost = scored(430.8, {"fitness": {"lowest": None, "highest": 511.0}})
    told = {**TOLD, "fitness": "fitness, LL eq. 5"}
    three = MotionComparison(
        "m", None, {"lucky": lucky, "steady": scored(380.0, {}), "lost": lost}, {}, told
    )
    each = zip(*metric_rows(three, every=True), strict=True)
    (line,) = [x for x in each if x[0][1] == "nominal" and x[0][3] == "380"]
    told = "362 to 511 (chaotic)", "380", "diverged to 511 (chaotic)"
    assert line == (["fitness, LL eq. 5", "nominal", *told], [3])
    repeats = "in 64 repeats with the command changed by up to one millionth"
    assert [*three.chaos()] == [
        f"lucky in m: fitness is chaotic: {repeats}, it ranges from 362 to 511",
        f"lost in m: fitness is chaotic: {repeats}, it ranges from diverged to 511",
    ]


@pytest.mark.parametrize("count", [1, 7, 1200, 1201, 10_000, 12_345])
def test_no_extreme_is_lost(count):
    values = np.random.default_rng(count).normal(size=count)
    found, size = extremes(values)
    assert len(found) <= 1200 or size == 1
    assert found.min() == values.min()
    assert found.max() == values.max()
    for k in range(0, len(found) - 1, 2) if size > 1 else ():
        own = values[k // 2 * size : (k // 2 + 1) * size]
        assert set(found[k : k + 2]) == {own.min(), own.max()}
        if own.argmin() != own.argmax():
            assert (found[k] == own.min()) == (own.argmin() < own.argmax())


def test_what_has_run_away_is_a_gap():
    values = np.arange(6000.0)
    values[3001:] = np.nan
    found, _ = extremes(values)
    assert np.nanmax(found) == 3000.0
    assert np.isnan(found[602:]).all()
