"""The limit of the rate of a command goes with the design as that of the command does.

The oracle is a ramp counted by hand, and a limit of the rate written down once more with NumPy.
"""

import numpy as np
import pytest
from c_program import built, commands
from held_back import FORMS, LIMITS, samples, stepped

import hfc_design.api as hfc


def slow(name, samples_to_the_limit=20, **changes):
    """A design that goes from rest to its largest command in so many samples."""
    design = hfc.load_design(name)
    limit = LIMITS[design.plant.name]
    rate = limit / (samples_to_the_limit * design.controller.sample_time_s)
    return hfc.load_design(name, changes | {"limits": {"command": limit, "command_rate": rate}})


def free(design):
    """The same, with commands as fast as they like."""
    return design.model_copy(update={"limits": design.limits.without_rate()})


def by_hand(asked, change):
    found, before = [], 0.0
    for command in asked:
        before = min(max(command, before - change), before + change)
        found.append(before)
    return np.array(found)


@pytest.mark.parametrize("case", FORMS)
def test_the_runtime_and_c_keep_it_alike(case, tmp_path):
    name, changes = FORMS[case]
    design = slow(name, **changes)
    signals = samples(design)
    change = design.limits.command_rate * design.controller.sample_time_s
    expected = stepped(design, signals)
    np.testing.assert_array_equal(expected, by_hand(stepped(free(design), signals), change))
    moves = np.abs(np.diff(expected, prepend=0.0))
    assert np.isclose(moves, change).sum() > 20  # it does hold back
    rows = np.stack(list(signals.values()), axis=1)
    found = commands(built("gcc", design, tmp_path / "c"), rows)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * design.limits.command)
    if "pid" in case:
        program = built("gcc", design, tmp_path / "float", "-DHFC_FLOAT")
        single = commands(program, rows, np.float32)
        np.testing.assert_allclose(single, expected, rtol=0, atol=1e-4 * design.limits.command)
        assert np.abs(np.diff(single, prepend=0.0)).max() <= change * (1.0 + 1e-5)
