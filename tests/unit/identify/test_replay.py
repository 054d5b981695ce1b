"""What a replay shifts, and what it takes the load to be between samples."""

import numpy as np
import pytest

from hfc_design.identify.replay import between, curved


def test_a_load_that_swings_is_not_cut_short():
    """Four points know its middle to the fourth order; straight lines are off by (w T)^2 / 8."""
    every, w = 1e-3, 50.0
    time = every * np.arange(200)
    load = np.sin(w * time)
    rise, bend = between(load)
    middle = curved(load, rise, bend, 0.5)[1:-2]
    exact = np.sin(w * (time + 0.5 * every))[1:-2]
    straight = (load + 0.5 * rise)[1:-2]
    assert np.abs(straight - exact).max() == pytest.approx((w * every) ** 2 / 8, rel=0.01)
    assert np.abs(middle - exact).max() < 1e-3 * (w * every) ** 2
    np.testing.assert_allclose(curved(load, rise, bend, 1.0)[:-1], load[1:], atol=1e-15)
