"""The limit of the rate of a command goes with the design: ramps counted by hand."""

import math

import pytest
from exported import texts, with_scenario
from structured_text import FunctionBlock
from wording import refused

import hfc_design.api as hfc
from hfc_design.formats.st import text_of
from hfc_design.runtime import Controller, Machine

#: u = 2 e - 0.5 de/dt [V], every 5 ms, up to 6 V and 100 V/s: 0.5 V a sample.
RAMP = {
    "controller.pd": {"kp": 2.0, "kd": -0.5},
    "controller.sample_time_s": 0.005,
    "limits": {"command": 6.0, "command_rate": 100.0},
}


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
    controller, block = Controller(pd()), FunctionBlock(text_of(pd()))
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


def test_a_loop_of_bare_code_with_a_slower_drive_is_refused():
    design = hfc.load_design("lin-lee-1999-table-1")
    with refused():
        texts(with_scenario(design, "c-axis-step", "limits.command_rate=400"), "linuxcnc")


@pytest.mark.parametrize("rate", [-1, float("inf")])
def test_a_rate_that_cannot_be_is_refused_in_a_line(rate):
    for load, name in ((hfc.load_scenario, "c-axis-step"), (hfc.load_design, "pd-only")):
        with refused() as found:
            load(name, {"limits.command_rate": rate})
        assert found.refusal.startswith(f"{found.where}: limits.command_rate = {rate!r}: ")
        assert "\n" not in found.refusal
