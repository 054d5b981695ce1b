"""What a replay shifts, and what it takes the load to be between samples."""

import numpy as np
import pytest

from hfc_design.identify.replay import between


def test_a_load_that_swings_is_not_cut_short():
    """Four points know its middle to the fourth order; straight lines are off by (w T)^2 / 8."""
    every, w = 1e-3, 50.0
    time = every * np.arange(200)
    load = np.sin(w * time)
    start, middle, end = between(load, 1).T
    exact = np.sin(w * (time + 0.5 * every))[1:-2]
    straight = 0.5 * (load[:-1] + load[1:])[1:-1]
    middle = middle[1:-2]
    assert np.abs(straight - exact).max() == pytest.approx((w * every) ** 2 / 8, rel=0.01)
    assert np.abs(middle - exact).max() < 1e-3 * (w * every) ** 2
    np.testing.assert_array_equal(start, load)
    np.testing.assert_allclose(end[:-1], load[1:], atol=1e-15)
