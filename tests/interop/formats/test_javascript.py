"""Exported JavaScript in Node: what the runtime commands, on random designs of every kind."""

import numpy as np
import pytest
from node import in_node
from random_designs import MADE, design_of, of_the_runtime, samples_of

SEEDS = range(6)
#: Kinds that call exp or tanh, which engines have of their own.
TRANSCENDENTAL = ("pd+hierarchical-fuzzy", "neural")


@pytest.mark.parametrize("kind", MADE)
def test_commands_are_those_of_the_runtime(program, kind, tmp_path):
    node = program("node")
    for seed in SEEDS:
        design = design_of(kind, seed)
        samples = samples_of(design, seed)
        found, wanted = in_node(node, design, samples, tmp_path), of_the_runtime(design, samples)
        exact = 1e-15 if kind not in TRANSCENDENTAL else 1e-13
        size = np.nanmax(np.abs(wanted))
        np.testing.assert_allclose(found, wanted, rtol=exact, atol=exact * size)
