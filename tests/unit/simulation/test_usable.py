"""Whether a design can be used: against runs of its own, poles, and the constraints by hand."""

import numpy as np
import pytest

from hfc_design.simulation.usable import gain_range


def test_the_range_of_gains_is_that_of_a_threshold():
    found = gain_range(lambda factors: np.append(1.0, factors) * 3.0 < 10.0)
    assert found[1] == pytest.approx(10.0 / 3.0, rel=3e-3)
    assert found[0] == pytest.approx(16.0 ** (-31 / 32))
    assert gain_range(lambda factors: np.append(1.0, factors) > 1.5) is None
