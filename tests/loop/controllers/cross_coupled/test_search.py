"""The cross-coupled controller in the loop: simulated and shown."""

import numpy as np
import pytest

import hfc_design.api as hfc
from hfc_design.controllers.controller import PathView
from hfc_design.controllers.kind import Shown
from hfc_design.motion.contour import local_error
from hfc_design.runs import individuals
from hfc_design.runtime import Machine

SHORT = {"simulation.duration_s": 4.0}
PID = {"kind": "pid", "ranges": {"k_p": [0.1, 4.0], "k_i": [0.0, 1.0]}}
SETTINGS = {"kind": "cross-coupled", "inner": {"kind": "per-axis", "axes": {"x": PID, "y": PID}}}


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
    told = {axis.name: axis.told() for axis in evaluation.axes}
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
    shown = Shown(scenario.plant.machine, scenario.plant.values(), None)
    titles = [part.title for part in design.kind.sections(design.controller, shown)]
    assert titles == ["Cross-coupling", "x: The controller", "y: The controller"]
