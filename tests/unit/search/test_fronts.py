"""Sorting and crowding against their definitions, counted point by point."""

import numpy as np
import pytest
from shaken import shaken

from hfc_design.search import fronts


def beats(one, other):
    """Whether one point is nowhere worse than another, and somewhere better."""
    return all(a <= b for a, b in zip(one, other, strict=True)) and any(
        a < b for a, b in zip(one, other, strict=True)
    )


def peeled(points):
    """Front of each point: the unbeaten ones taken away again and again."""
    found, left = {}, [*range(len(points))]
    while left:
        front = [k for k in left if not any(beats(points[j], points[k]) for j in left)]
        found |= dict.fromkeys(front, max(found.values(), default=-1) + 1)
        left = [k for k in left if k not in front]
    return [found[k] for k in range(len(points))]


@pytest.mark.parametrize("objectives", [2, 3])
@pytest.mark.parametrize("levels", [4, 1000])
def test_fronts_are_what_is_left_when_the_unbeaten_ones_are_taken_away(objectives, levels):
    points = np.random.default_rng(objectives).integers(levels, size=(80, objectives)).astype(float)
    found = fronts.front_numbers(points, np.zeros(80))
    assert found.tolist() == peeled(points.tolist())


def test_blocks_change_nothing(monkeypatch):
    points = np.random.default_rng(0).random((90, 2))
    whole = fronts.dominated(points, points)
    monkeypatch.setattr(fronts, "BLOCK", 7)
    assert np.array_equal(fronts.dominated(points, points), whole)


def test_who_breaks_less_comes_first_and_who_breaks_nothing_before_all():
    costs = np.array([[1.0, 1.0], [9.0, 9.0], [0.0, 0.0], [0.0, 0.0], [5.0, 5.0]])
    violation = np.array([0.0, 0.0, 0.2, 0.1, np.inf])
    assert fronts.front_numbers(costs, violation).tolist() == [0, 1, 3, 2, 4]
    assert fronts.best_first(costs, violation).tolist() == [0, 1, 3, 2, 4]


def test_crowding_by_hand():
    """Widths are 4 and 8: the point (1, 4) has neighbours 2 and 6 apart; (0, 8) stands twice."""
    costs = np.array([[0.0, 8.0], [1.0, 4.0], [2.0, 2.0], [4.0, 0.0], [0.0, 8.0]])
    own = [np.inf, 2 / 4 + 6 / 8, 3 / 4 + 4 / 8, np.inf, 0.0]
    assert fronts.crowding(costs).tolist() == own


def test_spread_out_keeps_the_ends_and_drops_who_counts_least_one_by_one():
    """Areas at first are 0.01, 0.04, 0.16 and, without the second point, 0.08 and 0.16."""
    x = np.array([0.0, 0.1, 0.2, 0.6, 1.0])
    costs = np.stack([x, 1.0 - x], axis=1)
    assert fronts.share(costs)[1:-1] == pytest.approx([0.01, 0.04, 0.16])
    assert fronts.spread_out(costs, 4).tolist() == [0, 2, 3, 4]
    assert fronts.spread_out(costs, 3).tolist() == [0, 3, 4]
    assert fronts.spread_out(costs, 9).tolist() == [0, 1, 2, 3, 4]


def test_a_share_of_two_costs_is_the_area_that_a_point_alone_dominates():
    """Of a front that bends: (3 - 1)(10 - 6) and (10 - 3)(6 - 2), in shares of 10 x 10."""
    costs = np.array([[3.0, 2.0], [10.0, 0.0], [0.0, 10.0], [1.0, 6.0]])
    assert fronts.share(costs) == pytest.approx([0.28, np.inf, np.inf, 0.08])


@pytest.mark.parametrize("objectives", [2, 3])
def test_who_counts_least_lies_between_two_that_are_near(objectives):
    rng = np.random.default_rng(objectives)
    costs = rng.random((40, objectives))
    costs /= costs.sum(axis=1, keepdims=True)  # on a plane nobody dominates
    near = costs[7] + 1e-4 * rng.standard_normal((2, objectives))
    near -= (near.sum(axis=1, keepdims=True) - 1.0) / objectives
    both = np.concatenate([costs, near])
    assert int(np.argmin(fronts.share(both))) in (7, 40, 41)
    ends = both.argmin(axis=0)
    assert np.isinf(fronts.share(both)[ends]).all()
    assert set(ends.tolist()) <= set(fronts.spread_out(both, 10).tolist())


def test_the_knee_is_farthest_below_the_line_between_the_ends():
    costs = np.array([[0.0, 100.0], [0.1, 30.0], [0.2, 10.0], [0.9, 5.0], [1.0, 0.0]])
    ends = costs[-1] - costs[0]
    away = [ends[0] * (p - costs[0])[1] - ends[1] * (p - costs[0])[0] for p in costs]
    assert fronts.knee(costs) == int(np.argmax(np.abs(away))) == 2


def test_the_knee_of_a_straight_front_is_its_first_point():
    """No point bends more than another, and no last bit is to choose one."""
    for costs in shaken(0.1, 0.3, 0.7, 0.9):
        x = np.array([0.0, *costs, 1.0])
        assert fronts.knee(np.column_stack([0.3 * x, 0.7 - 0.7 * x])) == 0
