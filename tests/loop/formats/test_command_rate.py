"""The limit of the rate of a command goes with the design as that of the command does.

The oracle is a ramp counted by hand, and a limit of the rate written down once more with NumPy.
"""

import numpy as np
import pytest
from held_back import FORMS, LIMITS, samples, stepped
from structured_text import FunctionBlock
from wiring import not_adapting

import hfc_design.api as hfc
from hfc_design.files.design import design_json
from hfc_design.formats import FORMATS, code
from hfc_design.runtime.explain import explanation


def slow(name, samples_to_the_limit=20, **changes):
    """A design that goes from rest to its largest command in so many samples."""
    design = hfc.load_design(name)
    limit = LIMITS[design.plant.name]
    rate = limit / (samples_to_the_limit * design.controller.sample_time_s)
    return hfc.load_design(name, changes | {"limits": {"command": limit, "command_rate": rate}})


def free(design):
    """The same, with commands as fast as they like."""
    return design.model_copy(update={"limits": design.limits.without_rate()})


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


def test_a_controller_of_a_whole_machine_keeps_it_in_the_simulator():
    limits = {"command": 6.0, "command_rate": 30.0, "axes": {"y": {"command_rate": 20.0}}}
    design = hfc.load_design("huang-cross-coupled", {"limits": limits})
    found = hfc.evaluate(design, hfc.load_scenario("milling-table-circle"))
    for axis, rate in zip(found.axes, (30.0, 20.0), strict=True):
        moves = np.abs(np.diff(axis.motion.command, prepend=0.0))
        assert moves.max() == pytest.approx(rate * 0.005, rel=1e-12)


def test_an_explanation_of_one_sample_leaves_it_out_and_says_so():
    design = slow("jee-koren-2004-flc")
    drive = hfc.load_scenario("feed-drive-line").machine.drives[0]
    texts = ["error=12,previous_error=12", "error=12", "error=12"]
    alone, after = (
        explanation(design, drive, drive.parameters(), some) for some in (texts[:1], texts[1:])
    )
    assert alone["rate_left_out"]
    assert (
        alone["command"]
        == explanation(free(design), drive, drive.parameters(), texts[:1])["command"]
    )
    assert not after["rate_left_out"]
    assert after["command"] == 2 * design.limits.command_rate * 0.01


def test_a_design_without_one_says_nothing_of_it():
    design = hfc.load_design("huang-pid", {"limits.command": 6.0})
    assert "command_rate" not in design_json(design)
    for to in ("c", "st", "plcopen", "linuxcnc"):
        assert "previous_command" not in str(FORMATS[to].content(design))
