"""One fuzzy unit: memberships (LL eq. 3) and inference (LL eq. 4)."""

from math import exp

import jax
import numpy as np
import oracle
import pytest

from hfc_design.controllers.hierarchical.law import (
    LIN_LEE_TERMS,
    Term,
    averaged,
    membership,
    memberships,
)
from hfc_design.simulation.closed_loop import LANES

TABLE = np.random.default_rng(2).uniform(-1.0, 1.0, (7, 7))
POINTS = np.random.default_rng(3).uniform(-1.5, 1.5, (50, 2))


def infer(xp, terms, table, column, row):
    return averaged(xp, table, memberships(xp, terms, column), memberships(xp, terms, row))


@jax.jit
def inferred(table, column, row):
    return infer(LANES, LIN_LEE_TERMS, table, column, row)


# By hand: exp(-rate (|u - centre| - half_width)^2), 1 on the flat top.
@pytest.mark.parametrize(
    ("term", "u", "degree"),
    [
        ("f1", -1.05, 1.0),
        ("f1", -0.9, 1.0),
        ("f1", -0.4, exp(-4 * 0.5**2)),
        ("f1", -1.6, exp(-4 * 0.5**2)),  # both sides fall, also outside the universe
        ("f2", -0.64, 1.0),
        ("f2", -0.5, exp(-8 * 0.05**2)),
        ("f3", -0.2, 1.0),
        ("f3", 0.05, exp(-32 * 0.25**2)),
        ("f4", 0.25, exp(-2)),
        ("f4", -0.125, exp(-0.5)),
        ("f5", 0.7, exp(-8)),
        ("f6", 0.0, exp(-8 * 0.55**2)),
        ("f7", 0.5, exp(-4 * 0.4**2)),
        ("f7", 1.1, 1.0),
    ],
)
def test_membership_by_hand(term, u, degree):
    (found,) = (t for t in LIN_LEE_TERMS if t.label == term)
    assert membership(LANES, found, np.float64(u)) == pytest.approx(degree, rel=1e-14)


def gauss2mf(x, sigma1, c1, sigma2, c2):
    """MATLAB's two-sided Gaussian, as its manual defines it."""
    left = 1.0 if x >= c1 else exp(-((x - c1) ** 2) / (2 * sigma1**2))
    right = 1.0 if x <= c2 else exp(-((x - c2) ** 2) / (2 * sigma2**2))
    return left * right


@pytest.mark.parametrize("term", LIN_LEE_TERMS, ids=lambda term: term.label)
def test_membership_is_gauss2mf(term):
    sigma = 1 / np.sqrt(2 * term.rate)
    shoulders = term.centre - term.half_width, term.centre + term.half_width
    for u in np.linspace(-1.5, 1.5, 61):
        wanted = gauss2mf(u, sigma, shoulders[0], sigma, shoulders[1])
        assert membership(LANES, term, u) == pytest.approx(wanted, rel=1e-12)


def test_inference_is_the_sum_over_49_rules():
    for column, row in POINTS:
        assert inferred(TABLE, column, row) == pytest.approx(
            oracle.infer(TABLE, column, row), rel=1e-12, abs=1e-14
        )


def test_other_terms_than_the_papers():
    terms = [Term(f"t{k}", 0.3 * k - 1.0, 0.02 * k, 5.0 + k) for k in range(7)]
    column, row = 0.17, -0.43
    degrees = [
        [exp(-t.rate * max(abs(u - t.centre) - t.half_width, 0.0) ** 2) for t in terms]
        for u in (row, column)
    ]
    firing = np.outer(*degrees)
    wanted = np.sum(firing * TABLE) / np.sum(firing)
    found = infer(LANES, terms, TABLE, np.float64(column), np.float64(row))
    assert found == pytest.approx(wanted)


def test_column_is_the_first_input_and_row_the_second():
    ramp = np.linspace(-1.0, 1.0, 7)
    over_columns, over_rows = np.tile(ramp, (7, 1)), np.tile(ramp[:, None], 7)
    # A table that only knows its columns follows the first input and ignores the second.
    assert inferred(over_columns, 0.9, -0.9) > 0.5
    assert inferred(over_columns, 0.9, -0.9) == pytest.approx(inferred(over_columns, 0.9, 0.3))
    assert inferred(over_rows, 0.9, -0.9) < -0.5
    assert inferred(over_rows, 0.9, -0.9) == pytest.approx(inferred(over_rows, -0.2, -0.9))


def test_equal_consequents_come_out_whatever_fires():
    for column, row in POINTS:
        assert inferred(np.full((7, 7), 0.37), column, row) == pytest.approx(0.37, rel=1e-14)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("level", [0.0, 1.6, 40.0])
def test_no_rule_fires_far_outside(dtype, level):
    table = (level + TABLE).astype(dtype)
    for column, row in [(40.0, 0.1), (0.1, 40.0), (-40.0, 40.0), (1e30, 0.0)]:
        assert inferred(table, dtype(column), dtype(row)) == 0.0


def test_float32_is_close_to_float64():
    for column, row in POINTS:
        single = inferred(TABLE.astype(np.float32), np.float32(column), np.float32(row))
        assert single.dtype == np.float32
        assert single == pytest.approx(oracle.infer(TABLE, column, row), abs=1e-6)
