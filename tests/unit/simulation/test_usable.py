"""Whether a design can be used: against runs of its own, poles, and the constraints by hand."""

import numpy as np
import pytest

from hfc_design.simulation.acceptance import gain_text
from hfc_design.simulation.usable import gain_range


@pytest.mark.parametrize(
    ("gain", "words"),
    [
        ((0.5, 2.0), "with the command multiplied by 0.5 to 2"),
        ((0.5, 16.0), "with the command multiplied by 0.5 to at least 16"),
        ((16.0 ** (-31 / 32), 2.0), "with the command multiplied by at most 0.0682 to 2"),
    ],
)
def test_beyond_the_ends_of_the_scan_nothing_is_said(gain, words):
    assert gain_text(gain) == words


def test_the_range_of_gains_is_that_of_a_threshold():
    found = gain_range(lambda factors: np.append(1.0, factors) * 3.0 < 10.0)
    assert found[1] == pytest.approx(10.0 / 3.0, rel=3e-3)
    assert found[0] == pytest.approx(16.0 ** (-31 / 32))
    assert gain_range(lambda factors: np.append(1.0, factors) > 1.5) is None
