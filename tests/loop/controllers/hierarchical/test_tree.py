"""Trees, genes and their evaluation (LL section 3.2)."""

import jax
import numpy as np
import oracle
import pytest

from hfc_design.controllers.hierarchical.law import LIN_LEE_TERMS, averaged, memberships
from hfc_design.controllers.hierarchical.tree import (
    all_sources,
    trees,
)
from hfc_design.simulation.closed_loop import LANES


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
