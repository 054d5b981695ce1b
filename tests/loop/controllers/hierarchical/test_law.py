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
    hierarchical,
    membership,
    memberships,
)
from hfc_design.controllers.hierarchical.record import HierarchicalDesign, layout_of
from hfc_design.controllers.hierarchical.tree import (
    all_sources,
    trees,
)
from hfc_design.core.lanes import LANES
from hfc_design.core.numbers import SCALARS
from hfc_design.files.loop_setup import load_design

TABLE = np.random.default_rng(2).uniform(-1.0, 1.0, (7, 7))
POINTS = np.random.default_rng(3).uniform(-1.5, 1.5, (50, 2))


def infer(xp, terms, table, column, row):
    return averaged(xp, table, memberships(xp, terms, column), memberships(xp, terms, row))


@jax.jit
def inferred(table, column, row):
    return infer(LANES, LIN_LEE_TERMS, table, column, row)


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


def test_float32_is_close_to_float64():
    for column, row in POINTS:
        single = inferred(TABLE.astype(np.float32), np.float32(column), np.float32(row))
        assert single.dtype == np.float32
        assert single == pytest.approx(oracle.infer(TABLE, column, row), abs=1e-6)


@pytest.mark.parametrize(("inputs", "sample"), [(2, 1), (6, 100)])
def test_trees_as_data_equal_recursion(inputs, sample):
    random = np.random.default_rng(inputs)
    chosen = random.permutation(len(trees(inputs)))[:sample]

    @jax.jit
    def evaluated(values, pairs, tables):
        values = list(values)
        for (column, row), table in zip(pairs, tables, strict=True):
            in_column, in_row = (
                memberships(LANES, LIN_LEE_TERMS, LANES.pick(dict(enumerate(values)), source))
                for source in (column, row)
            )
            values.append(averaged(LANES, table, in_column, in_row))
        return values[-1]

    for k in chosen:
        values = random.uniform(-1.0, 1.0, inputs)
        tables = random.uniform(-1.5, 1.5, (inputs - 1, 7, 7))
        pairs = all_sources(inputs)[k]
        wanted = oracle.output(oracle.nested(inputs, pairs.tolist(), tables), values.tolist())
        assert evaluated(values, pairs, tables) == pytest.approx(wanted, rel=1e-12, abs=1e-13)


SIGNALS = dict(zip(("error", "deflection", "deflection_rate"), (0.011, -0.004, 0.02), strict=True))


SIGNALS |= {"error_rate": -0.03, "spindle_velocity": 0.017}


def turned(record: HierarchicalDesign) -> HierarchicalDesign:
    """The same hierarchy with columns as rows."""
    data = record.model_dump()
    for unit in data["units"]:
        unit["column_input"], unit["row_input"] = unit["row_input"], unit["column_input"]
        unit["consequents"] = np.array(unit["consequents"]).T.tolist()
    return HierarchicalDesign.model_validate(data)


def command(xp, record, gains):
    law = hierarchical(layout_of(record), record.sample_time_s)
    return law.step(xp, gains, law.initial_memory(0.0), SIGNALS)[0]


@pytest.mark.parametrize(
    ("design", "canonical"), [("lin-lee-1999-table-1", True), ("lin-lee-1999-table-2", False)]
)
def test_a_turned_hierarchy_commands_the_same(design, canonical):
    record = load_design(design).controller
    other = turned(record)
    assert layout_of(record).canonical is canonical
    assert not layout_of(other).canonical
    exact = command(SCALARS, record, record.law_gains())
    assert command(SCALARS, other, other.law_gains()) == pytest.approx(exact, rel=1e-12)
    found = jax.jit(lambda own: command(LANES, other, own))(
        jax.tree.map(np.asarray, other.law_gains())
    )
    assert found == pytest.approx(exact, rel=1e-12)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("level", [0.0, 1.6, 40.0])
def test_no_rule_fires_far_outside(dtype, level):
    table = (level + TABLE).astype(dtype)
    for column, row in [(40.0, 0.1), (0.1, 40.0), (-40.0, 40.0), (1e30, 0.0)]:
        assert inferred(table, dtype(column), dtype(row)) == 0.0
