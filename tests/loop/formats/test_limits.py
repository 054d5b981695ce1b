"""The limit of a command goes with the design: into the simulator, the runtime, C and ST.

The oracle of the anti-windup is a PID written down once more with NumPy.
"""

import re

import numpy as np
import pytest
from held_back import FORMS, commanded_alone, limited, samples, stepped
from structured_text import FunctionBlock
from wiring import not_adapting

import hfc_design.api as hfc
from hfc_design.files.design import design_json
from hfc_design.formats import code


@pytest.mark.parametrize(
    "case", [case for case in FORMS if "lc" in case or "pid" in case or case.startswith("hier")]
)
def test_structured_text_keeps_it_too(case, tmp_path):
    name, changes = FORMS[case]
    design = limited(name, **changes)
    same = not_adapting(design) if design.kind.adapted else design  # the block has no adaptation
    signals = samples(design)
    (tmp_path / "block.st").write_text(code.block(design))
    block = FunctionBlock((tmp_path / "block.st").read_text())
    rows = zip(*(column.tolist() for column in signals.values()), strict=True)
    found = [block.step(**dict(zip(signals, row, strict=True))) for row in rows]
    np.testing.assert_allclose(found, stepped(same, signals), rtol=0, atol=1e-10)
    assert 0.95 * design.limits.command < np.abs(found).max() <= design.limits.command


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
    free = stepped(hfc.load_design("jee-koren-2004-pid"), {"error": errors})
    assert (found[302:] < 0.0).all()  # turns round at once
    assert (np.clip(free, -10.0, 10.0)[302:340] == 10.0).all()  # wound up it does not


@pytest.mark.parametrize(
    ("name", "scenario"),
    [
        ("lin-lee-1999-table-1", "c-axis-step"),
        ("hierarchy on a linear part", "c-axis-step"),
        ("adapting hierarchy on a linear part", "c-axis-step"),
        ("hierarchy that schedules", "c-axis-step"),
        ("jee-koren-2004-pid", "feed-drive-line"),
        pytest.param("jee-koren-2004-aflc", "feed-drive-line", marks=pytest.mark.slow),
    ],
)
def test_the_simulator_keeps_it_by_the_design_alone(name, scenario):
    name, changes = FORMS.get(name, (name, {}))
    design = limited(name, 7.0, **changes)
    found = hfc.evaluate(design, hfc.load_scenario(scenario, {"simulation.duration_s": 1.0}))
    for axis in found.axes:
        commanded_alone(design, axis)
        assert np.abs(axis.motion.command).max() == 7.0


def test_a_design_without_one_says_nothing_of_it():
    assert "limits" not in design_json(hfc.load_design("jee-koren-2004-pid"))


def test_an_axis_may_have_its_own(tmp_path):
    design = hfc.load_design(
        "jee-koren-2004-pid",
        {
            "plant.axes": {"x": {}, "y": {}},
            "limits.command": 9.0,
            "limits.axes.y": {"command": 4.0},
        },
    )
    found = hfc.evaluate(
        design, hfc.load_scenario("feed-drive-line", {"simulation.duration_s": 1.0})
    )
    assert [np.abs(axis.motion.command).max() for axis in found.axes] == [9.0, 4.0]
    hfc.export(design, "c", tmp_path / "c")
    text = (tmp_path / "c" / "y" / "jee_koren_2004_pid_y.c").read_text()
    assert "largest = R(4.0); /* command of either sign [unit] */" in text


def test_axes_of_limits_alone_are_those_of_the_scenario(tmp_path):
    """As edited by hand: the plant names no axes, the design's scenario has x and y."""
    changes = {"limits.command": 9.0, "limits.axes.y": {"command": 4.0}}
    design = hfc.load_design("jee-koren-2004-pid", changes)
    hfc.export(design, "c", tmp_path / "c")
    largest = r"largest = R\((.*)\); /\* command of either sign"
    for axis, limit in {"x": "9.0", "y": "4.0"}.items():
        text = (tmp_path / "c" / axis / f"jee_koren_2004_pid_{axis}.c").read_text()
        assert re.findall(largest, text) == [limit]
    hfc.export(design, "linuxcnc", tmp_path / "hal")
    page = (tmp_path / "hal" / "y" / "README.md").read_text()
    assert "keeps to 4.0 unit" in page


@pytest.mark.parametrize("axes", [None, {"x": {}, "y": {}}])
def test_a_limit_of_an_axis_that_is_not_there_is_refused(axes):
    changes = {"limits.axes.z": {"command": 4.0}} | ({"plant.axes": axes} if axes else {})
    with pytest.raises(hfc.UserError, match=r"limits\.axes\.z: there is no such axis, .* x, y"):
        hfc.load_design("jee-koren-2004-pid", changes)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"limits.command": -1}, "limits.command = -1: has to be greater than 0"),
        ({"limits.axes": {"z": {"command": 1}}}, "limits.axes.z: the machine has no such axis"),
        ({"limits.axes": {"x": {"command": 0}}}, "axes.x.command = 0"),
    ],
)
def test_a_limit_that_cannot_be_is_refused(changes, told):
    with pytest.raises(hfc.UserError, match=told):
        hfc.load_scenario("feed-drive-line", changes)
