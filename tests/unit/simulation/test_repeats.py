"""Repeats a millionth apart: against designs whose gains are multiplied by hand."""

import numpy as np
import pytest

from hfc_design.simulation.repeats import Repeats, averaged, chaos_text, range_text


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
        ([0.0, 0.0, 0.0], False, 0.0),
        ([-np.inf, 100.0, 90.0], False, -np.inf),  # it has diverged
        ([-np.inf] * 3, False, -np.inf),
    ],
)
def test_chaotic_is_what_differs_by_more_than_a_hundredth(values, chaotic, worth):
    many = Repeats(np.array(values))
    assert many.chaotic is chaotic
    assert many.worth == worth


def test_ranges_as_people_read_them():
    numbers = Repeats(np.array([430.8, 511.04, 361.96, 1.0])).numbers()
    assert numbers == {"lowest": 1.0, "median": 361.96, "highest": 511.04, "count": 4}
    assert range_text(numbers) == "1 to 511 (chaotic)"
    lost = Repeats(np.array([43080.4, 51104.3, -np.inf])).numbers()
    assert lost == {"lowest": None, "median": 43080.4, "highest": 51104.3, "count": 3}
    assert range_text(lost) == "diverged to 51104 (chaotic)"
    assert chaos_text("merit", lost).endswith("it ranges from diverged to 51104")
