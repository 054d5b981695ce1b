"""Repeats a millionth apart: against designs whose gains are multiplied by hand."""

import pytest

from hfc_design.files.named_scenario import load_scenario
from hfc_design.simulation.evaluating import evaluate


def test_repeats_of_several_motions_are_those_of_one_after_the_other():
    motions = [
        {"name": "ramp", "weight": 3.0},
        {"name": "slow", "reference": {"kind": "ramp", "velocity": 0.005}},
    ]
    both = {"motions": motions, "simulation": {"duration_s": 1.0}}
    scenario = load_scenario({"name": "two", "fitness": {"settled_after_s": 0.5}, **both})
    found = evaluate("pd-only", scenario)
    one, other = (found.motions[name].repeats["merit"].values for name in ("ramp", "slow"))
    expected = 4.0 / (3.0 / one + 1.0 / other)
    assert found.repeats["merit"].values == pytest.approx(expected, rel=1e-12)
    assert found.merit == pytest.approx(expected[0], rel=1e-12)
