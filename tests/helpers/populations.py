"""Populations on the built-in C-axis, as the simulator takes them and as the oracle does."""

import jax
import numpy as np
import oracle
from lifted import every_axis

from hfc_design.controllers.hierarchical.law import Layout, hierarchical
from hfc_design.files.named_scenario import load_scenario
from hfc_design.simulation import population as simulate
from hfc_design.simulation.closed_loop import closed_loop

LAW = hierarchical(Layout(), 0.001)
HIERARCHICAL = every_axis("pd+hierarchical-fuzzy", LAW)
LOADS = {"c-axis-ramp": None, "c-axis-ramp-cutting": oracle.cutting_load}


def prepared(controller, *changes, scenario="c-axis-ramp-cutting", seconds=0.2):
    """Loop, the machine and samples, ready for ``simulate.scores`` and the others."""
    found = load_scenario(scenario, [f"simulation.duration_s={seconds}", *changes])
    machines = simulate.one_machine(found.plant.values())
    return closed_loop(found, controller), machines, found.samples()


def trajectory(loop, machines, samples, gains, recorded=None):
    """Results of the judge and movements of one motion, see ``simulate.trajectories``."""
    judged, moved, _ = simulate.trajectories(loop, machines, [samples], gains, recorded)[0]
    return judged, moved


def simulated(scenario, controller, gains):
    """States (steps, 6, individuals) and the motion, of which the sample at 1 s is the last."""
    parts = prepared(controller, scenario=scenario, seconds=1.001)
    _, (motion,) = trajectory(*parts, gains)
    return np.stack(motion.state, axis=1), motion


def plain(gains, one):
    """What the oracle needs of one individual: nested tree, kp, kd."""
    tree = None
    if hasattr(gains, "sources"):
        sources, tables = gains.sources[..., one].tolist(), gains.consequents[..., one].tolist()
        tree = oracle.nested(len(gains.scales), sources, tables)
    return tree, float(gains.kp[one]), float(gains.kd[one])


def fitness(*arguments):
    """Of every individual on the only machine, nan where it failed."""
    loop, machines, samples, *others = arguments
    judged = simulate.scores(loop, machines, [samples], *others)
    assert judged.failed.shape[1:] == (1, 1)
    return np.where(judged.failed, np.nan, judged.values[..., 0])[:, 0, 0]


def picked(gains, which):
    return jax.tree.map(lambda leaf: leaf[..., which], gains)
