"""Populations of which the lost are dropped: the same bits as without, and who was lost."""

import pytest

from hfc_design.files.named_scenario import load_scenario
from hfc_design.objectives.objective import Left


def test_the_best_that_can_still_be_reached_is_by_hand():
    """Of sums after 1,000 of 1,500 samples, 300 of which of the 500 to come are settled."""
    judge = load_scenario("c-axis-ramp").judge()
    lin_lee, stuck = (2.0, 4.0), (30.0, 60.0)
    fitness = 1000.0 * (3.0 / 2.0 + 0.1 / 4.0)
    merit = float(judge.best((lin_lee, stuck), Left(500.0, 300.0)))
    assert merit == pytest.approx(fitness / (1.0 + 300.0 * 30.0 / 360.0))
    contour = load_scenario("feed-drive-circle").judge().objectives[0]
    best = contour.best((40.0, 2.0, 90.0, 10.0), Left(30.0, 0.0))
    assert float(best) == pytest.approx(1.0 / (1.0 + 0.3 * 2.0 + 0.01 * 1.5))
