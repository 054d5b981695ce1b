"""Limits of a command and of its rate go with the design: into the simulator, the runtime and ST.

The oracle of the anti-windup is a PID written down once more with NumPy.
"""

import re

import numpy as np
import pytest
from exported import texts
from held_back import FORMS, commanded_alone, in_text, limited, samples, slow, stepped
from wording import refused

import hfc_design.api as hfc
from hfc_design.formats import code

#: One of each law that has a block.
WRITTEN = [case for case in FORMS if ("lc" in case or "pid" in case) and "1995-" not in case]
WRITTEN = [case for case in WRITTEN if "one-plant" not in case]
WRITTEN += ["jee-koren-1995-soflc", "hierarchy that schedules"]


@pytest.mark.parametrize("case", WRITTEN)
def test_structured_text_keeps_them_too(case):
    name, changes = FORMS[case]
    for held in (limited, slow):
        design = held(name, **changes)
        signals = samples(design)
        found = in_text(design, signals)
        np.testing.assert_allclose(found, stepped(design, signals), rtol=0, atol=1e-10)
        if held is limited:
            limit = design.limits.command
            assert 0.95 * limit < np.abs(found).max() <= limit


def pid_by_hand(errors, k_p, k_i, k_d, every, limit):
    """Clamping: the sum stays while the command is beyond the limit and the error pushes on."""
    total, before, found = 0.0, 0.0, []
    for error in errors:
        rate = (error - before) / every
        command = k_p * error + k_i * every * (total + error) + k_d * rate
        if not (abs(command) > limit and error * command > 0.0):
            total += error
        command = k_p * error + k_i * every * total + k_d * rate
        found.append(np.clip(command, -limit, limit))
        before = error
    return np.array(found)


def test_a_sum_does_not_wind_up():
    design = limited("jee-koren-2004-pid", 10.0)
    errors = np.concatenate([np.full(300, 20.0), np.full(100, -2.0)])
    found = stepped(design, {"error": errors})
    gains = design.controller.pid
    by_hand = pid_by_hand(errors, gains.k_p, gains.k_i, gains.k_d, 0.01, 10.0)
    np.testing.assert_allclose(found, by_hand, rtol=1e-12)
    unlimited = stepped(hfc.load_design("jee-koren-2004-pid"), {"error": errors})
    assert (found[302:] < 0.0).all()  # turns round at once
    assert (np.clip(unlimited, -10.0, 10.0)[302:340] == 10.0).all()  # wound up it does not


def test_the_simulator_keeps_it_by_the_design_alone():
    """One that integrates and schedules; the others: tests/published."""
    name, changes = FORMS["hierarchy that schedules"]
    design = limited(name, 7.0, **changes)
    step = hfc.load_scenario("c-axis-step", {"simulation.duration_s": 1.0})
    (axis,) = hfc.evaluate(design, step).axes
    commanded_alone(design, axis)
    assert np.abs(axis.motion.command).max() == 7.0


def test_an_axis_may_have_its_own():
    axes = {"plant.axes": {"x": {}, "y": {}}, "limits.command": 9.0}
    design = hfc.load_design("jee-koren-2004-pid", axes | {"limits.axes.y": {"command": 4.0}})
    line = hfc.load_scenario("feed-drive-line", {"simulation.duration_s": 1.0})
    for axis, limit in zip(hfc.evaluate(design, line).axes, (9.0, 4.0), strict=True):
        commanded_alone(design.by_axis()[axis.name], axis)
        assert np.abs(axis.motion.command).max() == limit
    text = code.sources(design.by_axis()["y"])["jee_koren_2004_pid_y.c"]
    assert "own = R(4.0); /* command of either sign [unit] */" in text


def test_axes_of_limits_alone_are_those_of_the_scenario():
    """As edited by hand: the plant names no axes, the design's scenario has x and y."""
    changes = {"limits.command": 9.0, "limits.axes.y": {"command": 4.0}}
    found = texts(hfc.load_design("jee-koren-2004-pid", changes), "linuxcnc")
    for axis, limit in {"x": "9.0", "y": "4.0"}.items():
        text = found[f"{axis}/jee_koren_2004_pid_{axis}.c"]
        assert re.findall(r"own = R\((.*)\); /\* command of either sign", text) == [limit]
        assert f"limited to {limit} unit" in found[f"{axis}/README.md"]


def test_a_controller_of_a_whole_machine_keeps_its_rates_in_the_simulator():
    limits = {"command": 6.0, "command_rate": 30.0, "axes": {"y": {"command_rate": 20.0}}}
    design = hfc.load_design("huang-cross-coupled", {"limits": limits})
    found = hfc.evaluate(design, hfc.load_scenario("milling-table-circle"))
    for axis, rate in zip(found.axes, (30.0, 20.0), strict=True):
        moves = np.abs(np.diff(axis.motion.command, prepend=0.0))
        assert moves.max() == pytest.approx(rate * 0.005, rel=1e-12)


@pytest.mark.parametrize("axes", [{}, {"plant.axes": {"x": {}, "y": {}}}])
def test_a_limit_of_an_axis_that_is_not_there_is_refused(axes):
    with refused() as found:
        hfc.load_design("jee-koren-2004-pid", {"limits.axes.z": {"command": 4.0}} | axes)
    assert "limits.axes.z: " in found.refusal


@pytest.mark.parametrize(
    ("key", "value", "where"),
    [
        ("limits.command", -1, "limits.command"),
        ("limits.axes", {"z": {"command": 1}}, "limits.axes.z"),
        ("limits.axes", {"x": {"command": 0}}, "limits.axes.x.command"),
    ],
)
def test_a_limit_that_cannot_be_is_refused(key, value, where):
    with refused() as found:
        hfc.load_scenario("feed-drive-line", {key: value})
    assert f"{found.where}: {where}" in found.refusal


@pytest.mark.parametrize(("key", "given"), [("lag_s", 1e-3), ("delay_samples", 0.5)])
def test_the_fmu_of_a_loop_refuses_a_drive_that_it_does_not_simulate(key, given, tmp_path):
    design = hfc.load_design("pd-only", {f"limits.{key}": given})
    with refused() as line:
        hfc.export(design, "fmu-loop", tmp_path / "loop")
    assert f": limits.{key} = " in line.refusal
    assert [*tmp_path.iterdir()] == []
