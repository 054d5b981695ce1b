"""Repeats a millionth apart: against designs whose gains are multiplied by hand."""

import numpy as np
import pytest

from hfc_design.simulation.repeats import Repeats, averaged


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
