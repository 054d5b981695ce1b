"""The picture of a search whose merits are below zero, or of which all failed."""

import numpy as np
import pytest

from hfc_design.report import searches
from hfc_design.search.loop import History


@pytest.mark.parametrize(
    ("best", "scale"),
    [
        ([1.0, 10.0, 1e4], "log"),
        ([np.nan, 10.0, 1e4], "log"),
        ([-1e4, -10.0, 1e4], "linear"),
        ([np.nan, np.nan, np.nan], "linear"),
    ],
)
def test_only_what_is_above_zero_is_drawn_by_its_logarithm(best, scale):
    nothing = np.full(3, np.nan)
    history = History(np.array(best), nothing, np.array([9, 9, 9]), np.array([1, 1, 1]))
    scores, _ = searches.history(history, "loss $x^$ / (1 + 300 stick share)").axes
    assert scores.get_yscale() == scale
    assert scores.get_title() == "loss $x^$ / (1 + 300 stick share)"
