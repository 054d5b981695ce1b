"""The limit of the rate of a command goes with the design as that of the command does.

The oracle is a ramp counted by hand, and a limit of the rate written down once more with NumPy.
"""

import math

import numpy as np
import pytest
from c_program import built, commands
from held_back import FORMS, LIMITS, samples, stepped
from structured_text import FunctionBlock
from wiring import not_adapting

import hfc_design.api as hfc
from hfc_design.formats import code
from hfc_design.runtime import Controller

#: u = 2 e - 0.5 de/dt [V], every 5 ms, up to 6 V and 100 V/s: 0.5 V a sample.
RAMP = {
    "controller.pd": {"kp": 2.0, "kd": -0.5},
    "controller.sample_time_s": 0.005,
    "limits": {"command": 6.0, "command_rate": 100.0},
}


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


def pd(**changes):
    return hfc.load_design("pd-only", RAMP | changes)


def test_a_step_of_the_error_is_a_ramp_of_the_command():
    controller = Controller(pd())
    up = [controller.step({"error": 5.0, "error_rate": 0.0}) for _ in range(14)]
    assert up == [0.5 * min(k, 12) for k in range(1, 15)]  # to 6 V, though 10 V are asked for
    down = [controller.step({"error": 0.1, "error_rate": 0.0}) for _ in range(13)]
    assert down[:11] == [6.0 - 0.5 * k for k in range(1, 12)]
    assert down[11:] == [0.2, 0.2]  # 2 x 0.1, which is nearer than a whole change
    controller.reset()
    assert controller.step({"error": -5.0, "error_rate": 0.0}) == -0.5


def test_a_faulty_sample_leaves_the_ramp_where_it_was():
    controller, block = Controller(pd()), FunctionBlock(code.block(pd()))
    good, bad = ({"error": x, "error_rate": 0.0} for x in (5.0, math.nan))
    assert [controller.step(good), controller.step(good)] == [0.5, 1.0]
    assert math.isnan(controller.step(bad))
    assert controller.step(good) == 1.5
    assert [block.step(**good), block.step(**good)] == [0.5, 1.0]
    assert block.step(**bad) == 0.0
    assert block.step(**good) == 1.5


def test_what_is_too_large_to_be_a_number_is_a_fault_and_no_ramp():
    controller = Controller(pd(limits={"command_rate": 100.0}))
    assert math.isnan(controller.step({"error": 1e308, "error_rate": 0.0}))
    assert controller.step({"error": 5.0, "error_rate": 0.0}) == 0.5


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


@pytest.mark.parametrize("case", [case for case in FORMS if "lc" in case or "pid" in case])
def test_structured_text_keeps_it_too(case):
    name, changes = FORMS[case]
    design = slow(name, **changes)
    same = not_adapting(design) if design.kind.adapted else design  # the block has no adaptation
    signals = samples(design)
    block = FunctionBlock(code.block(design))
    rows = zip(*(column.tolist() for column in signals.values()), strict=True)
    found = [block.step(**dict(zip(signals, row, strict=True))) for row in rows]
    np.testing.assert_allclose(found, stepped(same, signals), rtol=0, atol=1e-10)
