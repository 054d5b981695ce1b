"""One number of many motions and machines, against numbers by hand."""

import numpy as np
import pytest
from wording import refused

from hfc_design import api
from hfc_design.objectives.constraints import Constraint
from hfc_design.objectives.judge import Judged
from hfc_design.objectives.metrics import RUNNING
from hfc_design.objectives.verdict import Ensemble

STUCK, LATE = Constraint(RUNNING["stick_slip"], 0.0), Constraint(RUNNING["late_error"], 0.01)


def judged(merit, failed=None, **values):
    """Of merits [design][machine][motion]; values of measures likewise."""
    merit = np.array(merit, float)
    failed = np.zeros(merit.shape, bool) if failed is None else np.array(failed)
    columns = [merit, *(np.broadcast_to(np.array(x, float), merit.shape) for x in values.values())]
    return Judged(merit, np.stack(columns, axis=-1), failed)


def test_motions_are_averaged_as_one_long_one():
    """LL eq. 5 of two motions after one another: 1 / (sum + sum), here twice the mean of costs."""
    found = Ensemble((1.0, 1.0)).verdict(judged([[[2.0, 6.0]]]))
    assert found.rank == pytest.approx([1.0 / (0.5 * (1 / 2.0 + 1 / 6.0))])
    weighed = Ensemble((3.0, 1.0)).verdict(judged([[[2.0, 6.0]]]))
    assert weighed.rank == pytest.approx([1.0 / (0.75 / 2.0 + 0.25 / 6.0)])


@pytest.mark.parametrize(
    ("keep", "rank"),
    [("worst", 1.0), ("quantile", 2.0), ("mean", 4.0 / (1 + 1 / 2 + 1 / 4 + 1 / 4))],
)
def test_machines(keep, rank):
    merit = [[[4.0], [1.0], [4.0], [2.0]]]
    found = Ensemble((1.0,), keep=keep, quantile=0.4).verdict(judged(merit))
    assert found.rank == pytest.approx([rank])
    assert found.merit.tolist() == [[4.0, 1.0, 4.0, 2.0]]
    assert found.sound.tolist() == [[True] * 4]


def test_a_motion_for_the_nominal_machine_alone():
    """It counts there as others do; elsewhere neither its cost nor what it breaks does."""
    ensemble = Ensemble((1.0, 3.0), (STUCK,), nominal=(False, True))
    merit = [[[2.0, 6.0], [4.0, 1e-9]], [[2.0, 6.0], [4.0, 5.0]], [[2.0, 6.0], [4.0, 5.0]]]
    stick = [[[0.0, 0.0], [0.0, 0.9]], [[0.0, 0.5], [0.0, 0.0]], [[0.0, 0.0], [0.5, 0.9]]]
    failed = [[[False, False], [False, True]], *[[[False] * 2] * 2] * 2]
    found = ensemble.verdict(judged(merit, failed, stick=stick))
    nominal = 1 / (0.25 / 2 + 0.75 / 6)
    assert found.merit == pytest.approx(np.array([[nominal, 4.0]] * 3))
    third = 0.5 / 1.5  # of what is one half over
    assert found.rank == pytest.approx([2 / (1 / nominal + 1 / 4), -third / 2, -third / 4])
    assert found.sound.tolist() == [[True, True], [False, True], [True, False]]
    costs = ensemble.costs(np.array([[[[1.0], [2.0]], [[3.0], [np.inf]]]]))
    assert costs.ravel() == pytest.approx([((0.25 + 1.5) + 3.0) / 2])


def test_a_share_of_the_machines_is_forgiven_but_never_the_nominal_one():
    """Of five beside the nominal one a fifth: the worst, whose cost does not count then."""
    ensemble = Ensemble((1.0,), (STUCK,), forgiven=0.2)
    stick = np.array([[0.0, 0, 0.5, 0, 0, 0], [0.5, 0, 0, 0, 0, 0], [0, 0, 0.1, 0, 1.0, 0]])
    merit = np.array([[1.0, 2, 1e-9, 2, 4, 4]] * 3)
    found = ensemble.verdict(judged(merit[..., None], stick=stick[..., None]))
    kept = 5 / (1 + 1 / 2 + 1 / 2 + 1 / 4 + 1 / 4)
    assert found.rank == pytest.approx([kept, -(0.5 / 1.5) / 5, -(0.1 / 1.1) / 5])
    assert found.sound[0].tolist() == [True, True, False, True, True, True]


def test_no_merit_buys_a_constraint_off():
    """Two machines, one motion; by how much it is broken decides, less than once a constraint."""
    ensemble = Ensemble((1.0,), (STUCK, LATE))
    stick = [[[0.0], [0.0]], [[0.1], [0.0]], [[0.0], [0.0]], [[0.0], [0.0]]]
    late = [[[0.01], [0.002]], [[0.0], [0.0]], [[0.012], [0.0]], [[9.9], [0.0]]]
    merit = [[[1e-3]] * 2, [[1e6]] * 2, [[1e6]] * 2, [[1e6]] * 2]
    found = ensemble.verdict(judged(merit, stick=stick, late=late))
    assert found.rank == pytest.approx([1e-3, -0.1 / 1.1 / 2, -0.2 / 1.2 / 2, -989 / 990 / 2])
    assert found.sound.tolist() == [[True, True], [False, True], [False, True], [False, True]]


def test_a_search_may_weigh_what_is_broken():
    ensemble = Ensemble((1.0,), (STUCK,))
    stick = [[[0.0]], [[0.1]], [[0.5]]]
    told = judged([[[2.0]], [[9.0]], [[99.0]]], stick=stick)
    assert ensemble.verdict(told).rank == pytest.approx([2.0, -0.1 / 1.1, -1 / 3])
    weighed = [2.0, 9.0 * np.exp(-2.0), 99.0 * np.exp(-22 / 3)]
    assert ensemble.verdict(told, 22.0).weighed == pytest.approx(weighed)
    assert ensemble.verdict(told, 22.0).sound.ravel().tolist() == [True, False, False]
    # exp(-2,333) is 0 to a computer: the violation ranks, below whatever is left of others
    weighed = [2.0, 9.0 * np.exp(-7000 / 11), -1 / 3]
    assert ensemble.verdict(told, 7000.0).weighed == pytest.approx(weighed, rel=1e-9)


def test_what_fails_breaks_everything_and_only_what_always_fails_is_lost():
    ensemble = Ensemble((1.0,), (STUCK, LATE))
    failed = [[[True], [False]], [[True], [True]]]
    merit = [[[np.nan], [5.0]], [[np.inf], [np.nan]]]
    found = ensemble.verdict(judged(merit, failed, stick=np.nan, late=0.0))
    assert found.merit.tolist() == [[0.0, 5.0], [0.0, 0.0]]
    # A share of sticking that is no number counts as one that is broken.
    assert found.rank == pytest.approx([-(3.0 + 1.0) / 2, -np.inf])


@pytest.mark.parametrize(
    ("name", "most"),
    [("stick", 0), ("chatter", -1), ("estimated_max_contour_error", 1)],
)
def test_constraints_that_cannot_be(name, most):
    with refused() as found:
        api.load_scenario({"constraints": {name: most}})
    assert f"constraints.{name}" in found.refusal


@pytest.mark.parametrize("forgiven", [0.0, 0.3])
@pytest.mark.parametrize("keep", ["worst", "quantile", "mean"])
def test_what_can_still_be_reached_is_never_less_than_what_is(keep, forgiven):
    """On eight machines, of 2,000 designs of which about half break something on one."""
    rng = np.random.default_rng(5)
    shape = (2000, 8, 2)
    late = np.where(rng.random(shape) < 0.12, 0.01 + 0.02 * rng.random(shape), 0.0)
    failed = rng.random(shape) < 0.01
    own = judged(np.exp(rng.standard_normal(shape)), failed, late=late)
    ensemble = Ensemble(
        (1.0, 2.0), (LATE,), keep, quantile=0.3, forgiven=forgiven, nominal=(False, True)
    )
    before = np.full(2000, np.inf)
    rank = ensemble.verdict(own).rank
    assert 0.1 < (rank < 0.0).mean() < 0.9
    for seen in range(1, 9):
        some = Judged(*(x[:, :seen] for x in own))
        reach = ensemble.best_rank(some, 8)
        assert (reach >= rank - 1e-9 * np.abs(np.where(np.isfinite(rank), rank, 0.0))).all()
    if not forgiven:  # all have been seen, and nothing is left to hope for
        finite = np.isfinite(rank)
        assert reach[finite] == pytest.approx(rank[finite])
    few = ensemble.best_rank(Judged(*(x[:, :3] for x in own)), 8)
    assert (few < before).mean() > (0.9 if keep == "mean" and not forgiven else 0.02)


def test_what_can_still_be_reached_by_hand():
    """Costs 1/4 and 1/2 of four machines; a nominal one that breaks a quarter of what is one."""
    found = Ensemble((1.0,)).best_rank(judged([[[4.0], [2.0]]]), 4)
    assert found == pytest.approx([4.0 / (1 / 4 + 1 / 2)])
    late = [[[0.01 * 4 / 3], [0.0]]]
    broken = Ensemble((1.0,), (LATE,)).best_rank(judged([[[4.0], [2.0]]], late=late), 4)
    assert broken == pytest.approx([-0.25 / 4])


def test_a_penalty_weighs_broken_constraints_against_merit_by_hand():
    """Four machines of merits 4, 4, 2, 1: costs 0.25, 0.25, 0.5, 1, together 2.

    The last is late by a third of what is allowed, so that a quarter of what is one is broken.
    """
    merit = [[[4.0], [4.0], [2.0], [1.0]]]
    late = [[[0.0], [0.0], [0.0], [0.01 * 4 / 3]]]
    own, ensemble = judged(merit, late=late), Ensemble((1.0,), (LATE,))
    for rank in (ensemble.verdict(own, 8.0).rank, ensemble.verdict(own).weighed):
        assert rank == pytest.approx([-0.25 / 4])
    assert ensemble.verdict(own, 0.0).weighed == pytest.approx([4 / 2])
    assert ensemble.verdict(own, 8.0).weighed == pytest.approx([2.0 * np.exp(-8 * 0.25 / 4)])


def test_a_machine_that_fails_costs_twenty_medians_where_constraints_are_weighed():
    """Three costs of 1/2 and one of 20/2; a failure breaks itself and the one constraint."""
    failed = [[[False], [False], [False], [True]]]
    own, ensemble = (
        judged([[[2.0]] * 4], failed, late=np.zeros((1, 4, 1))),
        Ensemble((1.0,), (LATE,)),
    )
    assert ensemble.verdict(own, 6.0).weighed == pytest.approx(
        [4 / (1.5 + 10.0) * np.exp(-6 * 2 / 4)]
    )


def test_a_search_may_allow_less():
    ensemble = Ensemble((1.0,), (STUCK, LATE)).tighter(2.0)
    assert [one.most for one in ensemble.constraints] == [0.0, 0.005]
    assert ensemble.verdict(judged([[[1.0]]], stick=0.0, late=0.006)).rank == pytest.approx(
        [-1 / 6]
    )


def test_half_of_the_machines_that_fail_are_weighed_against_nothing():
    failed = np.array([[[False], [True], [True], [True]]])
    own = judged(np.full((1, 4, 1), 2.0), failed, late=np.zeros((1, 4, 1)))
    assert Ensemble((1.0,), (LATE,)).verdict(own, 6.0).weighed == pytest.approx([-6 / 4])
