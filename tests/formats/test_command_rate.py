"""The limit of the rate of a command goes with the design as that of the command does.

The oracle is a ramp counted by hand, and a limit of the rate written down once more with NumPy.
"""

import math
import re

import numpy as np
import pytest
from c_program import built, commands
from held_back import FORMS, LIMITS, commanded_alone, samples, stepped
from structured_text import FunctionBlock
from wiring import not_adapting

import hfc_design.api as hfc
from hfc_design.files.design import design_json, parse_design
from hfc_design.formats import FORMATS, code
from hfc_design.runtime import Controller, Machine
from hfc_design.runtime.explain import explanation

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


@pytest.mark.parametrize(
    ("name", "scenario"),
    [("lin-lee-1999-table-1", "c-axis-step"), ("jee-koren-2004-pid", "feed-drive-line")],
)
def test_the_simulator_keeps_it_by_the_design_alone(name, scenario):
    design = slow(name)
    change = design.limits.command_rate * design.controller.sample_time_s
    found = hfc.evaluate(design, hfc.load_scenario(scenario, {"simulation.duration_s": 1.0}))
    for axis in found.axes:
        commanded_alone(design, axis)
        if name.startswith("lin"):  # whose drive takes a command as it is
            moves = np.abs(np.diff(axis.motion.command, prepend=0.0))
            assert np.isclose(moves, change).sum() > 10
            assert moves.max() <= change * (1.0 + 1e-12)


def test_a_controller_of_a_whole_machine_keeps_it_in_the_simulator():
    limits = {"command": 6.0, "command_rate": 30.0, "axes": {"y": {"command_rate": 20.0}}}
    design = hfc.load_design("huang-cross-coupled", {"limits": limits})
    found = hfc.evaluate(design, hfc.load_scenario("milling-table-circle"))
    for axis, rate in zip(found.axes, (30.0, 20.0), strict=True):
        moves = np.abs(np.diff(axis.motion.command, prepend=0.0))
        assert moves.max() == pytest.approx(rate * 0.005, rel=1e-12)


def test_the_axes_of_a_machine_have_their_own():
    limits = {"command_rate": 100.0, "axes": {"y": {"command_rate": 60.0}, "z": {}}}
    design = pd(limits=limits, **{"plant.axes": {"x": {}, "y": {}, "z": {}}})
    machine = Machine(design)
    good = {axis: {"error": 5.0, "error_rate": 0.0} for axis in "xyz"}
    assert machine.step(good) == {"x": 0.5, "y": 0.3, "z": 0.5}
    told = machine.step(good | {"x": {"error": math.inf, "error_rate": 0.0}})
    assert math.isnan(told["x"])
    assert (told["y"], told["z"]) == (0.6, 1.0)
    assert machine.step(good)["x"] == 1.0
    machine.reset()
    assert machine.step(good) == {"x": 0.5, "y": 0.3, "z": 0.5}


@pytest.mark.slow
def test_a_slower_drive_of_a_scenario_bounds_it_further():
    scenario = {"limits": {"command": 5.0, "command_rate": 400.0}, "simulation.duration_s": 0.2}
    step = hfc.load_scenario("c-axis-step", scenario)
    fast = hfc.load_design("lin-lee-1999-table-1", {"limits.command_rate": 4000.0})
    for design in (hfc.load_design("lin-lee-1999-table-1"), fast):
        (axis,) = hfc.evaluate(design, step).axes
        moves = np.abs(np.diff(axis.motion.command, prepend=0.0))
        assert moves.max() == pytest.approx(0.4, rel=1e-12)
        assert np.abs(axis.motion.command).max() == 5.0
    # One that is faster than the controller changes nothing.
    own = hfc.load_design("lin-lee-1999-table-1", {"limits.command_rate": 400.0})
    found, other = (
        hfc.evaluate(own, hfc.load_scenario("c-axis-step", scenario | {"limits": limits}))
        for limits in ({"command_rate": 900.0}, {})
    )
    np.testing.assert_array_equal(found.axes[0].motion.command, other.axes[0].motion.command)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["pd", "pd+hierarchical-fuzzy"])
def test_what_a_search_finds_was_searched_with_it_and_keeps_it(kind):
    changes = {
        "limits": {"command": 25.0, "command_rate": 500.0},
        "simulation.duration_s": 0.3,
        "controller": {"kind": kind},
        "search.population": 16,
        "search.generations": 2,
    }
    scenario = hfc.load_scenario("c-axis-ramp", changes)
    run = hfc.design(scenario)
    assert run.design.limits.command_rate == 500.0
    again = hfc.evaluate(parse_design(design_json(run.design), "again"), scenario)
    assert again.merit == run.evaluation.merit
    for found in (run.evaluation, again):
        (axis,) = found.axes
        assert np.abs(np.diff(axis.motion.command, prepend=0.0)).max() <= 0.5 * (1.0 + 1e-12)
    huge = dict.fromkeys(run.design.kind.reads(run.design.controller), 0.0) | {"error": 10.0}
    assert Controller(run.design).step(huge) == 0.5


@pytest.mark.slow
def test_what_is_learnt_comes_back_without_what_was_commanded():
    design = hfc.load_design("huang-soc", {"limits.command_rate": 40.0})
    scenario = hfc.load_scenario("milling-table-circle", {"simulation.duration_s": 1.0})
    found = hfc.learned_in(design, scenario, hfc.evaluate(design, scenario))
    assert found.limits == design.limits
    both = found.controller.axes.values()
    assert all(own.table != design.controller.table for own in both)
    one, other = (Controller(design, "x") for design in (found, free(found)))
    errors = 0.2 * np.sin(np.arange(100) / 9.0)
    own, asked = (np.array([x.step({"error": e}) for e in errors.tolist()]) for x in (one, other))
    assert np.abs(np.diff(asked)).max() > 0.3
    np.testing.assert_array_equal(own, by_hand(asked, 0.2))


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


@pytest.mark.parametrize("to", ["fmu-loop", "linuxcnc"])
def test_a_loop_with_a_slower_drive_is_refused(to, tmp_path):
    scenario = hfc.load_scenario("c-axis-step", {"limits.command_rate": 400.0})
    told = {"scenario": scenario.model_dump(mode="json", exclude_none=True)}
    design = hfc.load_design("lin-lee-1999-table-1").model_copy(update={"provenance": told})
    with pytest.raises(hfc.UserError, match=r"limits.command_rate = 400.0: the drive is slower"):
        hfc.export(design, to, tmp_path / "out")


def test_a_design_without_one_says_nothing_of_it():
    design = hfc.load_design("huang-pid", {"limits.command": 6.0})
    assert "command_rate" not in design_json(design)
    for to in ("c", "st", "plcopen", "linuxcnc"):
        assert "previous_command" not in str(FORMATS[to].content(design))


@pytest.mark.parametrize(
    ("rate", "told"),
    [
        (-1, "limits.command_rate = -1: has to be greater than 0"),
        (0, "limits.command_rate = 0: has to be greater than 0"),
        ("fast", "limits.command_rate = 'fast': has to be a number"),
        (float("inf"), "limits.command_rate = inf: has to be a finite number"),
    ],
)
def test_a_rate_that_cannot_be_is_refused_in_a_line(rate, told):
    for load, name in ((hfc.load_scenario, "c-axis-step"), (hfc.load_design, "pd-only")):
        with pytest.raises(hfc.UserError, match=re.escape(told)) as caught:
            load(name, {"limits.command_rate": rate})
        assert "\n" not in str(caught.value)
