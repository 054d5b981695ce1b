"""What a comparison says: best values, units, words where there is no number, rows of a CSV."""

import numpy as np
import pytest

from hfc_design.files.named_scenario import load_scenario
from hfc_design.pictures.numbers import readable
from hfc_design.report.comparison.tables import difference_row, failures, lines
from hfc_design.simulation.comparison import (
    Comparison,
    DesignStatistics,
    MotionComparison,
    _differences,
)

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
    all_, interval, *others = lines(bout(a=a, b=b, c=c))
    assert all_.cells == ["66.7", "100", "0"]
    assert all_.best == [1]
    assert interval.cells[1] == "29.2–100"  # 0.025 ** (1 / 3)
    assert [line.metric for line in others] == ["rms error [µrad]", "", ""]
    assert [(line.of, line.cells, line.best) for line in others] == [
        ("nominal", ["200", "500", "unstable"], [0]),
        ("median", ["200", "500", "unstable"], [0]),  # of 100 200 and a failure
        ("95 %", ["unstable", "500", "unstable"], [1]),
    ]


def test_equal_ones_are_not_marked():
    assert all(line.best == [] for line in lines(bout(a=side([1.0]), b=side([1.0]))))
    (*_, median, _) = lines(bout(a=side([1.0]), b=side([1.0]), c=side([2.0])))
    assert median.best == [0, 1]


def test_a_difference_as_a_row():
    a, b = side([1.0] * 40), side([4.0] * 40, [True] * 30 + [False] * 10)
    (found,) = _differences([bout(a=a, b=b)])
    assert difference_row(found) == [
        *("0.25 (0.25–0.25)", "40 of 40 (91–100 %)", "< 0.0001", "30", "10, 0", "0")
    ]
    (other,) = _differences([bout(a=b, b=side([1.0] * 40))])
    assert difference_row(other)[0] == "4 (4–∞)" or other.ratio_interval[1] == 4.0
    (none,) = _differences([bout(a=side([1.0] * 6, [False] * 6), b=side([1.0] * 6))])
    assert difference_row(none)[0] == "∞ (∞–∞)"


def test_failures_are_said():
    lost = {
        "a": side([1.0] * 3, [True, False, False]),
        "b": side([1.0] * 3, [False] * 3, nominal_stable=False),
        "c": side([1.0] * 3),
    }
    found = Comparison(
        {}, 0.2, 0, 3, [bout(**lost)._replace(scenario=load_scenario("c-axis-ramp"))], [], []
    )
    (told,) = failures(found)
    assert told == "not stable in m: a on 2, b on 3 and the nominal of 3 machines"


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
    (line,) = [x for x in lines(three, every=True) if x.cells[1] == "380" and x.of == "nominal"]
    assert line.cells == ["362 to 511 (chaotic)", "380", "diverged to 511 (chaotic)"]
    assert line.best == [1]
    repeats = "in 64 repeats with the command changed by up to one millionth"
    assert [*three.chaos()] == [
        f"lucky in m: fitness is chaotic: {repeats}, it ranges from 362 to 511",
        f"lost in m: fitness is chaotic: {repeats}, it ranges from diverged to 511",
    ]
