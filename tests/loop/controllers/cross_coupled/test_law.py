"""Cross-coupled control against hand calculation, in plain numbers and in the simulator."""

import json
from math import cos, isnan, nan, radians, sin

import numpy as np
import pytest
from two_axes import of_both
from wording import refused

import hfc_design.api as hfc
from hfc_design.controllers.controller import PathView
from hfc_design.controllers.kind import ReportContext
from hfc_design.files.design import design_json, parse_design
from hfc_design.motion.contour import local_error
from hfc_design.runs import individuals
from hfc_design.runtime import Machine

EVERY = 0.01
PID = {"kind": "pid", "pid": {"k_p": 4.0, "k_i": 0.0, "k_d": 0.0}}


def design(limit=None, inner=PID, **controller):
    own = {"kind": "cross-coupled", "inner": inner, "contour": {"k_p": 6.0}}
    return of_both(own | controller, limit)


def step(machine, path, errors, rate=(0.0, 0.0)):
    """A sample at a place of ``path`` (tangent, curvature) with these tracking errors."""
    tx, ty, curvature = path
    dx, dy = (-error for error in errors)
    view = PathView((tx, ty), curvature, local_error(dx, dy, tx, ty, curvature))
    pairs = zip("xy", errors, rate, strict=True)
    told = {axis: {"error": e, "reference_rate": r} for axis, e, r in pairs}
    return view.contour_error, machine.step(told, view)


def along_a_line(controller, angle, loads, samples=2000, gain=10.0):
    """Where the errors of two integrators under constant loads end, along and across a line."""
    tangent, speed = np.array([cos(radians(angle)), sin(radians(angle))]), 100.0
    machine, place = Machine(controller), np.zeros(2)
    for k in range(samples):
        error = k * EVERY * speed * tangent - place
        _, found = step(machine, (*tangent, 0.0), error, speed * tangent)
        place = place + EVERY * gain * (np.array([found["x"], found["y"]]) - loads)
    return tangent @ error, np.array([tangent[1], -tangent[0]]) @ error


@pytest.mark.parametrize("angle", [0.0, 30.0, 200.0])
def test_what_a_load_leaves_of_the_contour_error(angle):
    """Across: load / (k_p inside + k_p outside); along: load / k_p inside."""
    loads = np.array([7.0, -3.0])
    tangent = np.array([cos(radians(angle)), sin(radians(angle))])
    along, across = loads @ tangent, loads @ [tangent[1], -tangent[0]]
    ahead = {"x": 1 / 10.0, "y": 1 / 10.0}
    found = along_a_line(design(feed_forward=ahead), angle, loads)
    assert found == pytest.approx((along / 4.0, across / (4.0 + 6.0)), rel=1e-9)
    integral = design(contour={"k_p": 2.0, "k_i": 9.0, "k_d": 0.01}, feed_forward=ahead)
    found = along_a_line(integral, angle, loads)
    assert found == pytest.approx((along / 4.0, 0.0), abs=1e-6)
    # Without the feed-forward a command of 100 / 10 is missing, along the path.
    found = along_a_line(design(), angle, loads)
    assert found == pytest.approx(((along + 100 / 10) / 4.0, across / 10.0), rel=1e-9)


@pytest.mark.parametrize("radius", [40.0, -40.0])
def test_the_normal_is_that_of_koren_and_lo(radius):
    """C_x = sin t - e_x / (2 R), C_y = cos t + e_y / (2 R) of Koren & Lo (1991), t from x to y."""
    inner = {"kind": "pid", "pid": {"k_p": 0.0, "k_i": 0.0, "k_d": 0.0}}
    for angle in (0.0, radians(30.0), radians(200.0)):
        path, (x, y) = (cos(angle), sin(angle), 1.0 / radius), (0.4, 0.3)
        off, found = step(Machine(design(inner=inner)), path, (x, y))
        c_x, c_y = sin(angle) - x / (2.0 * radius), cos(angle) + y / (2.0 * radius)
        assert list(found.values()) == pytest.approx([6.0 * off * c_x, -6.0 * off * c_y], rel=1e-12)


def test_its_integral_does_not_wind_up_beyond_a_limit():
    machine = Machine(design(20.0, contour={"k_p": 1.0, "k_i": 10.0}))
    for _ in range(1000):  # 8 on the left of a path along x, y pushed down: 32 + 8 + integral
        _, found = step(machine, (1.0, 0.0, 0.0), (0.0, -8.0))
        assert found == {"x": 0.0, "y": -20.0}
    assert machine._memory.integral == 0.0
    for k in range(3):  # now on the right, within the limit: it counts from there on
        _, found = step(machine, (1.0, 0.0, 0.0), (0.0, 1.0))
        assert found["y"] == pytest.approx(4.0 + 1.0 + 0.1 * (k + 1), rel=1e-14)


def test_a_fault_of_an_axis_or_of_the_path_is_one_of_both():
    machine, other = Machine(design()), Machine(design())
    line = (0.6, 0.8, 0.0)
    for broken in ((line, (nan, 1.0)), ((0.6, nan, 0.0), (1.0, 1.0))):
        assert all(map(isnan, step(machine, *broken)[1].values()))
    assert step(machine, line, (1.0, 2.0)) == step(other, line, (1.0, 2.0))


def test_without_a_path_it_says_so():
    told = {axis: {"error": 1.0, "reference_rate": 0.0} for axis in "xy"}
    with refused():
        Machine(design()).step(told)
    scenario = hfc.load_scenario(
        "feed-drive-line",
        {"reference": {"kind": "per-axis", "axes": {key: {"kind": "ramp"} for key in "xy"}}}
        | {"fitness": {"kind": "lin-lee"}, "simulation.duration_s": 0.1},
    )
    with refused():
        hfc.evaluate(design(), scenario)
    changes = {"controller": {"kind": "cross-coupled", "inner": {"kind": "pid"}}}
    with refused() as found:
        hfc.load_scenario("c-axis-ramp", changes)
    assert found.where == "c-axis-ramp"


@pytest.mark.parametrize(
    "changes",
    [
        {"feed_forward": {"y": 0.1, "x": 0.1}},
        {"inner": PID | {"sample_time_s": 0.02}},
        {"inner": {"kind": "per-axis", "axes": {"x": PID}}},
    ],
)
def test_what_does_not_fit_is_named(changes):
    data = json.loads(design_json(design()))
    data["controller"] |= changes
    with refused():  # as it is read, or on its machine
        Machine(parse_design(json.dumps(data), "mine.json"))


SHORT = {"simulation.duration_s": 4.0}
SEARCHED = {"kind": "pid", "ranges": {"k_p": [0.1, 4.0], "k_i": [0.0, 1.0]}}
SETTINGS = {
    "kind": "cross-coupled",
    "inner": {"kind": "per-axis", "axes": {"x": SEARCHED, "y": SEARCHED}},
}


@pytest.fixture(scope="module")
def found():
    """A scenario, and one of the individuals that its search begins with."""
    scenario = hfc.load_scenario("feed-drive-circle", {**SHORT, "controller": SETTINGS})
    own = individuals.genome_of(scenario)
    some = own.fresh(np.zeros(1, int), np.random.default_rng(1))
    return scenario, individuals.design_of(some, scenario)


def test_the_runtime_gives_the_commands_of_the_simulator(found):
    scenario, design = found
    evaluation = hfc.evaluate(design, scenario)
    machine = Machine(design, ("x", "y"))
    told = {axis.name: axis.sensed() for axis in evaluation.axes}
    path = scenario.samples().path
    for k in range(len(evaluation.time)):
        now = {axis: {key: float(x[k]) for key, x in own.items()} for axis, own in told.items()}
        tangent, curvature = [float(x[k]) for x in path.tangent], float(path.curvature[k])
        off = local_error(-now["x"]["error"], -now["y"]["error"], *tangent, curvature)
        commands = machine.step(now, PathView(tuple(tangent), curvature, off))
        for axis in evaluation.axes:
            # The converter rounds to whole units, 8 bits of them.
            held = min(max(round(commands[axis.name]), -128), 127)
            assert held == axis.motion.command[k]


def test_the_page_shows_its_gains(found):
    scenario, design = found
    shown = ReportContext(scenario.plant.machine, scenario.plant.values(), None)
    titles = [part.title for part in design.kind.sections(design.controller, shown)]
    assert titles == ["Cross-coupling", "x: The controller", "y: The controller"]
