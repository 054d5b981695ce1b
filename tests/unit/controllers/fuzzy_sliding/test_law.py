"""The law against SciPy and hand calculations; what it learns and what it may not learn."""

import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator
from sliding import DYNAMICS, EVERY, PID, TABLE_2, sliding, table

from hfc_design.controllers.fuzzy_sliding import law as lg
from hfc_design.controllers.neighbours import spread
from hfc_design.core.numbers import SCALARS
from hfc_design.runtime import Controller


def told(design, error, rate, memory=None, limit=None):
    record = design.controller
    law = lg.sliding(record.sample_time_s, limit)
    memory = memory or law.initial_memory(0.0)
    signals = {"error": error, "error_rate": rate}
    return law.sample(SCALARS, law, record.law_gains(), memory, signals)


def test_table_2_is_odd():
    """So are the numbers that the scan runs together at the end of its rows."""
    np.testing.assert_array_equal(TABLE_2, -TABLE_2[::-1, ::-1])
    assert (np.diff(TABLE_2, axis=0)[:, 1:-1] >= 0).all()


def test_the_rules_interpolate_between_their_centres():
    """Product, centre average, triangles: the multilinear interpolation of SciPy."""
    design = sliding(consequents=np.random.default_rng(1).uniform(-9, 9, (7, 7)).tolist())
    record = design.controller
    axes = [np.linspace(-x, x, 7) for x in (record.largest_error, record.largest_error_rate)]
    oracle = RegularGridInterpolator(axes, record.consequents)
    points = np.random.default_rng(0).uniform(-1.5, 1.5, (500, 2)) * [60.0, 2000.0]
    found = [told(design, *point)[2].fuzzy for point in points.tolist()]
    inside = np.clip(points, [-60.0, -2000.0], [60.0, 2000.0])
    np.testing.assert_allclose(found, oracle(inside), rtol=0, atol=1e-12)


def test_a_sample_by_hand():
    """e = 30 is between SP (20) and MP (40), de/dt = 1000 between SP (666.7) and MP (1333.3)."""
    command, memory, parts = told(sliding(), 30.0, 1000.0)
    assert parts.fuzzy == pytest.approx((80.0 + 80.0 + 80.0 + 120.0) / 4.0)  # MP, MP; MP, LP
    assert parts.sliding == 1000.0 + 20.0 * 30.0
    assert parts.switching == 10.0  # beyond the layer of 300
    assert command == parts.fuzzy + 10.0
    moved = np.zeros((7, 7))
    moved[4:6, 4:6] = 0.01 * 2.0 * 1600.0 * 0.25  # T gamma s xi
    np.testing.assert_allclose(memory.moves, moved, atol=1e-12)
    assert told(sliding(), 1.0, 10.0)[2].switching == pytest.approx(10.0 * 30.0 / 300.0)


def test_a_pid_stands_beside_the_rules():
    memory, sums = None, 0.0
    for error, rate in ((3.0, 40.0), (-1.0, 20.0), (5.0, -60.0)):
        sums += error
        command, memory, parts = told(sliding(pid=PID), error, rate, memory)
        expected = 1.5 * error + 8.0 * 0.01 * sums + 0.02 * rate
        assert parts.pid == pytest.approx(expected)
        assert command == pytest.approx(parts.fuzzy + parts.switching + expected)


def test_what_judges_solves_the_lyapunov_equation():
    dynamics = sliding(adaptation={"rate": 1.0, "largest_move": 200.0, "error_dynamics": DYNAMICS})
    assert dynamics.controller.judge() == pytest.approx((12.5, 0.7))


def test_the_judge_left_out_is_that_of_two_poles_at_the_slope():
    """P_2 = (lambda, 1) for k = (lambda^2, 2 lambda), Q = 2 lambda diag(lambda^2, 1)."""
    slope = 20.0
    double = {
        "gains": [slope**2, 2.0 * slope],
        "weights": [[2.0 * slope**3, 0.0], [0.0, 2.0 * slope]],
    }
    own = {"rate": 1.0, "largest_move": 200.0, "error_dynamics": double}
    assert sliding(adaptation=own).controller.judge() == pytest.approx(sliding().controller.judge())


def test_the_projection_keeps_to_its_box_and_harms_nothing():
    """It only touches what leaves the box, and brings it nearer to all that is inside."""
    random, bound = np.random.default_rng(2), False
    design, memory = sliding(adaptation={"rate": 50.0, "largest_move": 30.0}), None
    for error, rate in (random.standard_normal((300, 2)) * [40.0, 1500.0]).tolist():
        before = np.array(memory.moves) if memory else np.zeros((7, 7))
        _, memory, parts = told(design, error, rate, memory)
        free = before + 0.01 * 50.0 * (20.0 * error + rate) * np.outer(
            spread(parts.in_error, 7), spread(parts.in_rate, 7)
        )
        np.testing.assert_allclose(memory.moves, np.clip(free, -30.0, 30.0), atol=1e-10)
        inside = random.uniform(-30.0, 30.0, (7, 7))
        off, without = np.linalg.norm(memory.moves - inside), np.linalg.norm(free - inside)
        assert off <= without
        bound |= off < without
    assert bound


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_command_at_its_limit_teaches_nothing_that_winds_up(sign):
    """e > 0 pushes further, a rate that is falling fast takes back."""
    _, memory, parts = told(sliding(), 50.0 * sign, 0.0, limit=90.0)
    assert abs(parts.fuzzy + parts.switching) > 90.0
    assert not np.any(memory.moves)
    back = sliding(consequents=np.full((7, 7), 120.0 * sign).tolist())
    _, memory, parts = told(back, -50.0 * sign, 0.0, limit=90.0)
    assert np.abs(memory.moves).max() > 0.0


def test_what_it_learnt_is_a_design_that_goes_on():
    """A controller that begins with the learnt table commands as the one that goes on does."""
    controller, random = Controller(EVERY["alone"]), np.random.default_rng(3)
    errors = (random.standard_normal((200, 2)) * [20.0, 300.0]).tolist()
    for error, rate in errors:
        controller.step({"error": error, "error_rate": rate})
    learnt = controller.adapted()
    assert np.abs(np.subtract(learnt.table(), table())).max() > 1.0
    assert learnt.consequents == EVERY["alone"].controller.consequents  # the box stays about them
    other = Controller(EVERY["alone"].model_copy(update={"controller": learnt}))
    for error, rate in errors:
        signals = {"error": error, "error_rate": rate}
        assert other.step(signals) == pytest.approx(controller.step(signals), abs=1e-11)
