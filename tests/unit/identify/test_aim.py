"""What of a log stands in the scenario that is made of it."""

import numpy as np
import pytest
from carts import EVERY, recorded

from hfc_design.identify.scenario import differences

PLACE = 1e-6 * np.round(2e4 * np.sin(0.02 * np.arange(2000)))


@pytest.mark.parametrize("samples", [1, 4, 16])
def test_a_velocity_is_a_difference_over_samples(samples):
    """By the control, which prints six digits; one that is measured apart is none."""
    told = recorded(PLACE, PLACE)
    rate = np.zeros(len(PLACE))
    rate[samples:] = (PLACE[samples:] - PLACE[:-samples]) / (samples * EVERY)
    with_rate = told._replace(outputs=told.outputs | {"velocity": np.round(rate, 6)})
    expected = {"difference_samples": samples} if samples > 1 else {}
    assert differences(with_rate, "velocity") == expected
    assert differences(told, "velocity") == {}
    smooth = 0.4 * np.cos(0.02 * np.arange(2000))
    assert differences(told._replace(outputs={"velocity": smooth} | told.outputs), "velocity") == {}
