"""Faulty samples: of several axes, of a controller that sees the whole machine, of an own law.

Every kind, in C and Structured Text too: tests/attack/test_nan.py.
"""

from math import inf, isnan, nan
from typing import Literal, NamedTuple

import numpy as np
import pytest
from wording import refused

import hfc_design.api as hfc
from hfc_design.controllers.controller import PathView
from hfc_design.controllers.kinds import KINDS
from hfc_design.files.design import Design
from hfc_design.runtime import Controller, Machine

PID, AFLC = "jee-koren-2004-pid", "jee-koren-2004-aflc"
ERRORS = np.random.default_rng(0).normal(0.0, 8.0, 40).tolist()


def on_two_axes(**controller):
    design = hfc.load_design(PID).model_dump(mode="json")
    design["plant"]["axes"] = {"x": {}, "y": {}}
    return Design.model_validate(design | ({"controller": controller} if controller else {}))


@pytest.mark.parametrize("several_kinds", [False, True])
def test_a_fault_is_of_its_axis_alone(several_kinds):
    own = {"x": PID, "y": AFLC} if several_kinds else {"x": PID, "y": PID}
    records = {axis: hfc.load_design(name).controller for axis, name in own.items()}
    dumped = {axis: record.model_dump(mode="json") for axis, record in records.items()}
    per_axis = {"kind": "per-axis", "sample_time_s": 0.01, "axes": dumped}
    machine = Machine(on_two_axes(**per_axis) if several_kinds else on_two_axes())
    alone = {axis: Controller(hfc.load_design(name)) for axis, name in own.items()}
    for k, error in enumerate(ERRORS):
        broken = {3: "x", 7: "y", 8: "y"}.get(k)
        found = machine.step(
            {axis: {"error": nan if axis == broken else error + k} for axis in ("x", "y")}
        )
        for axis, controller in alone.items():
            if axis == broken:
                assert isnan(found[axis])
            else:
                assert found[axis] == controller.step({"error": error + k})


def test_a_signal_that_is_missing_moves_no_axis():
    machine, other = Machine(on_two_axes()), Machine(on_two_axes())
    with pytest.raises(KeyError, match="error"):
        machine.step({"x": {"error": 3.0}, "y": {}})
    good = {"x": {"error": 1.0}, "y": {"error": 2.0}}
    assert machine.step(good) == other.step(good)


def test_what_is_wrong_with_signals_is_a_line():
    machine = Machine(on_two_axes())
    for signals in ({"eror": 1.0}, {"error": "1"}, {"error": None}, 3):
        with refused() as alone:
            Controller(PID).step(signals)
        with refused() as within:
            machine.step({"x": {"error": 1.0}, "y": signals})
        assert alone.error.lines == within.error.lines
        assert len(alone.error.lines) == 1
    with refused():
        machine.step({"x": {"error": 1.0}})


def test_limits_of_axes_that_nothing_else_names():
    """Of one axis alone nobody knows which others the machine has."""
    design = hfc.load_design(PID).model_dump(mode="json")
    design["limits"] = {"axes": {"y": {"command": 5.0}}}
    design = Design.model_validate(design)
    with refused() as found:
        Machine(design)
    assert "limits.axes" in found.refusal
    both = Machine(design, ("x", "y")).step({"x": {"error": 50.0}, "y": {"error": 50.0}})
    assert both["x"] > both["y"] == 5.0


class Coupled(NamedTuple):
    """Pushes each axis by the sum of all errors so far, and towards the path."""

    kind: str = "coupled"

    def initial_memory(self, zero):
        return {"sum": zero}

    def step(self, xp, gains, memory, view):
        total = memory["sum"] + sum(signals["error"] for signals in view.axes)
        away = view.path.contour_error if view.path else 0.0
        return tuple(total / signals["gap"] - away for signals in view.axes), {"sum": total}


def test_a_controller_of_the_whole_machine_is_faulty_as_a_whole(own_plugins, monkeypatch):
    class Record(hfc.ControllerRecord):
        """No gains."""

        kind: Literal["coupled"] = "coupled"

        def law_gains(self):
            return ()

        def controller(self, limits):
            return Coupled()

        def reads(self):
            return ["error", "gap"]

    monkeypatch.setitem(KINDS.known, "coupled", Record)
    machine = Machine(on_two_axes(kind="coupled", sample_time_s=0.01))

    def step(x, y, path=None, gap=2.0):
        found = machine.step({"x": {"error": x, "gap": gap}, "y": {"error": y, "gap": 1.0}}, path)
        return tuple(found.values())

    assert step(1.0, 2.0) == (1.5, 3.0)
    faulty = [step(nan, 1.0), step(1.0, -inf), step(1.0, 1.0, PathView((1.0, 0.0), 0.0, nan))]
    faulty += [step(1.0, 1.0, gap=0.0), step(1.7e308, 1.7e308)]  # a division by zero, an overflow
    assert np.isnan(faulty).all()
    assert step(1.0, 0.0, PathView((1.0, 0.0), 0.0, 0.5)) == (1.5, 3.5)


def test_what_an_own_law_reads_is_found_by_asking(own_plugins):
    """Of a faulty reading that it does not read nothing hangs on; what it remembers counts."""

    class Gains(NamedTuple):
        """Of a made-up law."""

        k: object

    def step(every, gains, memory, signals):
        return gains.k * signals["error"], (memory[0] + 1.0, memory[1] * signals["error"])

    law = hfc.Law("made-up-law", Gains((0.1, 10.0)), lambda zero: (zero, 2.0 + zero), step)
    hfc.register(law)
    data = hfc.load_design(PID).model_dump(mode="json")
    data["controller"] = {"kind": "made-up-law", "sample_time_s": 0.01, "gains": {"k": 2.0}}
    controller = Controller(Design.model_validate(data))
    assert controller.step({"error": 3.0, "mode": "fast"}) == 6.0
    assert isnan(controller.step({"error": nan}))
    assert isnan(controller.step({"error": 8e307, "velocity": nan}))  # its memory would be 4.8e308
    assert controller._memory == (1.0, 6.0)
    assert controller.step({"error": 1.0, "velocity": nan}) == 2.0


def test_a_remembered_reading_is_finite():
    controller = Controller(hfc.load_design("jee-koren-2004-flc"))
    with refused(ValueError):
        controller.remember({"error": nan})
    assert controller.step({"error": 3.0}) == Controller(controller._whole).step({"error": 3.0})
