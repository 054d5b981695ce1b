"""Every metric by hand on small motions."""

import numpy as np
import pytest

from hfc_design.objectives.judge import judge
from hfc_design.objectives.lin_lee import lin_lee
from hfc_design.objectives.objective import Moment


def scored(fitness, moments, stick_penalty=0.0):
    """The merit of samples (error, error_rate, reference_rate, settled)."""
    judging = judge(fitness, stick_penalty)
    sums = judging.initial(np.float64(0.0))
    for error, error_rate, reference_rate, settled in moments:
        sums = judging.update(
            sums, (Moment(error, error_rate, -error, 0.0, reference_rate, settled),), None
        )
    return float(judging.judged(sums, [np.float64(0.0)]).merit)


def test_score_of_equation_5_by_hand():
    moments = [(0.5, -2.0, 0.0, 1.0), (-1.5, 3.0, 0.0, 1.0)]
    assert scored(lin_lee(3.0, 0.1), moments) == pytest.approx(1000 * (3 / 2.0 + 0.1 / 5.0))
    assert scored(lin_lee(2.0, 0.0), moments) == pytest.approx(1000.0)


def test_sticking_takes_its_share_of_the_score():
    """Stuck is an error rate between 0.9 and 1.1 of the commanded 1 rad/s; the first is early."""
    rates = [1.0, 0.95, 0.0, 1.05, 1.2]
    moments = [(1.0, rate, 1.0, float(k > 0)) for k, rate in enumerate(rates)]
    plain = 1000 * (3 / 5 + 0.1 / sum(rates))
    assert scored(lin_lee(), moments, 4.0) == pytest.approx(plain / (1 + 4 * 0.5))
    assert scored(lin_lee(), moments, 0.0) == pytest.approx(plain)
