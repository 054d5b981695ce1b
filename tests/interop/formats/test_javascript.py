"""Exported JavaScript in Node: what the runtime commands, on random designs of every kind."""

import json
import subprocess

import numpy as np
import pytest
from node import in_node
from random_designs import MADE, design_of, of_the_runtime, samples_of

from hfc_design.formats import code
from hfc_design.formats.scripts import module

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


def test_the_module_says_what_it_reads(program, tmp_path):
    design = design_of("aflc", 1)
    (tmp_path / "law.mjs").write_text(module(design))
    text = 'import { signals, sampleTime } from "./law.mjs";'
    text += "console.log(JSON.stringify([signals, sampleTime]));"
    (tmp_path / "ask.mjs").write_text(text)
    told = subprocess.check_output([program("node"), "ask.mjs"], cwd=tmp_path, text=True)
    assert json.loads(told) == [dict(code.signals(design)), 0.01]
