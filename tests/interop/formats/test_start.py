"""A controller at its start and at its limits: the runtime, C, Structured Text and controller.m.

By hand: while all signals stand no change is other than 0, so that what neither integrates nor
learns commands the same in every sample, and what learns begins with the command of its first
table. At a limit no sum grows: once the error has turned the command leaves the limit at once.
"""

import numpy as np
import pytest
from c_program import built, together
from c_program import commands as run_c
from held_back import FORMS, limited
from structured_text import FunctionBlock

import hfc_design.api as hfc
from hfc_design.controllers.controller import PathView
from hfc_design.files.design import Limits
from hfc_design.formats.st import text_of
from hfc_design.runtime import Controller, Machine

PID, FLC, HIERARCHY = "jee-koren-2004-pid", "jee-koren-2004-flc", "lin-lee-1999-table-1"
STILL = {
    PID: {"controller.pid.k_i": 0.0, "controller.dead_zone": 1.0},
    FLC: {},
    HIERARCHY: {},
    "huang-neural": {"controller.rate": 0.0},
}
#: A change of so much is another term than one of 0: it would be seen.
STANDS = {"error": 12.0, "spindle_velocity": 0.03}
SMALL = {HIERARCHY: 0.001, "huang-soc": 0.02, "huang-neural": 0.02}
#: What has a sum, its error and the turned one.
WINDING = {
    PID: (30.0, -3.0),
    "flc that integrates": (30.0, -3.0),
    "flc of form PI": (30.0, -3.0),
    "aflc that integrates": (30.0, -3.0),
    "soflc that integrates": (30.0, -3.0),
    "hierarchy on a linear part": (0.05, -0.005),
    "adapting hierarchy on a linear part": (0.05, -0.005),
    "hierarchy that schedules": (0.05, -0.005),
}
STEADY = {"controller.contour.k_i": 0.0, "controller.inner.pid.k_i": 0.0}


def standing(name, changes):
    design = hfc.load_design(name, changes)
    names = design.kind.reads(design.controller)
    return design, {key: STANDS.get(key, 0.0) for key in names} | {
        "error": SMALL.get(name, STANDS["error"])
    }


def in_python(design, rows, folder):
    controller = Controller(design)
    return [controller.step(row) for row in rows]


def in_c(design, rows, folder):
    return run_c(built("gcc", design, folder), [[*row.values()] for row in rows])


def in_st(design, rows, folder):
    block = FunctionBlock(text_of(design))
    return [block.step(**row) for row in rows]


def within(design, rows, folder):
    """In C that is told the limit; the design's own is three times as large."""
    limit = design.limits.command
    own = {"own": design.model_copy(update={"limits": Limits(command=3.0 * limit)})}
    run = together(own, folder, within={"own": limit})
    return run("own", [[*row.values()] for row in rows])


IN = {"python": in_python, "c": in_c, "st": in_st}


@pytest.mark.parametrize("name", STILL)
@pytest.mark.parametrize("language", IN)
def test_a_standing_error_is_no_kick(language, name, tmp_path):
    design, row = standing(name, STILL[name])
    found = IN[language](design, [row] * 3, tmp_path)
    assert abs(found[1]) > 0.1
    np.testing.assert_allclose(found, found[1], rtol=1e-13)
    if name == PID:
        assert found[0] == pytest.approx(12.0 * design.controller.pid.k_p, rel=1e-13)


def test_forgetting_is_a_first_sample_again():
    design, row = standing(PID, STILL[PID])
    controller, block = Controller(design), FunctionBlock(text_of(design))
    both = [controller.step(row), block.step(**row)]
    controller.reset()
    again = row | {"error": -50.0}
    both += [controller.step(again), block.step(**again, reset=True)]
    k_p = design.controller.pid.k_p
    np.testing.assert_allclose(both, k_p * np.array([12.0, 12.0, -50.0, -50.0]), rtol=1e-13)


@pytest.mark.parametrize("case", WINDING)
@pytest.mark.parametrize("run", [in_python, in_c, within, in_st])
def test_a_turned_error_takes_the_command_off_its_limit(run, case, tmp_path):
    """In its second sample, as the change of the error drives in the first."""
    name, changes = FORMS[case]
    design = limited(name, **changes)
    still = dict.fromkeys(design.kind.reads(design.controller), 0.0)
    rows = [still | {"error": error} for error in np.repeat(WINDING[case], [200, 4])]
    limit = design.limits.command
    found = np.array(run(design, rows, tmp_path))
    assert 0.85 * limit < found[199] <= limit
    assert -limit < found[201] < found[199]
    free = design.model_copy(update={"limits": Limits()})
    assert min(in_python(free, rows, None)[200:]) > limit  # a sum that nothing holds
    if case == PID:
        gains, every = design.controller.pid, design.controller.sample_time_s
        by_hand = -3.0 * (gains.k_p + gains.k_i * every * np.array([1.0, 2.0, 3.0]))
        np.testing.assert_allclose(found[201:], by_hand, rtol=1e-12)


def test_a_contour_error_that_stands_is_no_kick():
    machine = Machine(hfc.load_design("huang-cross-coupled", STEADY), ("x", "y"))
    axes = {axis: {"error": 0.0, "reference_rate": 0.0} for axis in machine.axes}
    path = PathView((1.0, 0.0), 0.0, 0.01)
    first, second = (machine.step(axes, path) for _ in range(2))
    assert first == second != dict.fromkeys(machine.axes, 0.0)
