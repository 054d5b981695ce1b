"""Margins of a design's loop as it is simulated, at the speeds of a scenario's motions."""

from typing import NamedTuple

import jax
import numpy as np

from hfc_design.core.numbers import Floats, Json
from hfc_design.core.plugins import own_code
from hfc_design.files.design import AnyDesign
from hfc_design.files.named_scenario import AnyScenario, load_scenario
from hfc_design.files.pairing import controller_of, load_design, machine, with_converter
from hfc_design.files.scenario import Scenario
from hfc_design.motion.samples import Samples
from hfc_design.simulation.closed_loop import Loop, closed_loop
from hfc_design.simulation.linearised import Controllers, Steady, controlled, loops, steady
from hfc_design.simulation.population import Machines, one_machine, standing
from hfc_design.simulation.sensors import largest_command
from hfc_design.stability.loop_report import At, LoopMargins, band, numbers
from hfc_design.stability.margins import OpenLoop, largest, margins

#: Machines beside the nominal one that the band is of.
BAND = 20
#: Speeds of a path that differ by no more are the same.
ALIKE = 1.01
#: A motion that is slower than this share of its highest speed stands.
STANDS = 0.01
#: A response that is nowhere larger is none.
LOOKED_AT, NOTHING = np.geomspace(1e-3, 3.0, 9), 1e-9
HELD = "a small command moves nothing that is measured there: friction or a gap holds it"
OPEN = "the law does not answer a small error there, so that the loop is open"


class Point(NamedTuple):
    """A steady motion of a machine."""

    name: str
    row: Samples  # one column
    speeds: tuple[float, ...]  # of each axis [of its position, per s]


def operating_points(scenario: Scenario) -> list[Point]:
    """At rest, and where each motion is slowest and fastest; each speed once."""
    found: dict[tuple[float, ...], Point] = {}
    for motion in scenario.each_motion():
        samples, name = motion.samples(), motion.name.removeprefix(f"{scenario.name}.")
        rates = np.array([own.reference_rate for own in samples.axes])
        sizes = np.linalg.norm(rates, axis=0)
        # Where it is so for a while, as on a circle, all axes are to move.
        alike = np.abs(rates).min(axis=0) / max(sizes.max(), np.finfo(float).tiny)
        slow, fast = sizes <= sizes.min() * ALIKE, sizes * ALIKE >= sizes.max()
        slowest, fastest = (int(np.where(some, alike, -1.0).argmax()) for some in (slow, fast))
        places = {"at rest": 0, "slowest": slowest, "fastest": fastest}
        for where, k in places.items():
            still = where == "at rest" or sizes[k] <= STANDS * sizes.max()
            speeds = tuple(float(f"{0.0 if still else x:.6g}") for x in rates[:, k])
            speed = f"{name} {where}" if len(speeds) > 1 else f"{abs(speeds[0]):g}"
            row = _steady_row(motion, samples, k, speeds)
            found.setdefault(speeds, Point(speed if any(speeds) else "at rest", row, speeds))
    return sorted(found.values(), key=lambda one: np.linalg.norm(one.speeds))


def _steady_row(motion: Scenario, samples: Samples, k: int, speeds: tuple[float, ...]) -> Samples:
    """Column ``k`` as if the machine had always moved so, under its constant load."""

    def own(leaf: Floats) -> Floats:
        return np.asarray(leaf, float)[..., k]

    axes = []
    for name, axis, speed in zip(motion.machine.axes, samples.axes, speeds, strict=True):
        one = jax.tree.map(own, axis)
        load = motion.load.of(name).constant
        rate = {"reference_rate": np.float64(speed)}
        if one.reference_acceleration is not None:
            rate["reference_acceleration"] = np.float64(0.0)
        axes.append(one._replace(loads=0.0 * one.loads + load, noise=0.0 * one.noise, **rate))
    whole = samples._replace(axes=(), sample_time=(), start=(), beside=())
    rest = {"sample_time": samples.sample_time, "start": samples.start}
    return jax.tree.map(own, whole)._replace(axes=tuple(axes), **rest)


def near(loop: Loop, machines: Machines, points: list[Point]) -> Steady:
    """The machines of a loop without a controller, at the points of each one after the other."""
    count = machines.size
    true = jax.tree.map(lambda leaf: np.repeat(leaf, len(points)), machines.true)
    rows = jax.tree.map(
        lambda *leaves: np.stack([np.asarray(x, float) for x in leaves] * count),
        *(point.row for point in points),
    )
    return steady(loop, machines.told, true, rows, np.array([x.speeds for x in points] * count))


def loop_margins(
    design: AnyDesign, scenario: AnyScenario, machines: Machines | None = None
) -> LoopMargins:
    """Margins of a design at the operating points of a scenario.

    ``machines`` are the nominal one and others, of which a band is told; without them the nominal
    one alone.

    Raises:
        UserError: the two do not fit, or an own part cannot be linearised.
    """
    design = load_design(design)
    scenario = with_converter(load_scenario(scenario), design)
    controller, gains = controller_of(design, scenario)
    loop = closed_loop(scenario, controller)
    if machines is None:
        machines = one_machine(machine(design, scenario).values())
    machines = machines.take(np.arange(min(machines.size, BAND + 1)))
    parts = [("plant", drive.name) for drive in loop.machine.drives]
    parts += [("plant", loop.machine.name), ("controller", design.controller.kind)]
    with own_code(" cannot be linearised", *parts):
        points = operating_points(scenario)
        about = near(loop, standing(machines, scenario, loop), points)
        lanes = np.zeros(len(about.found), int)
        every = jax.tree.map(lambda leaf: np.take(leaf, lanes, axis=-1), gains)
        own = controlled(loop, machines.told, every, about)
    rows, count, axes = [], len(points), scenario.machine.axes
    for n, point in enumerate(points):
        each = [
            _at(scenario, about, own, n + k * count, machines.take(k)) for k in range(machines.size)
        ]
        for axis, of_axis in zip(axes, zip(*each, strict=True), strict=True):
            (why, nominal, open_loop), *others = of_axis
            known = [told for _, told, _ in others if told]
            name = axis if len(axes) > 1 else ""
            rows.append(At(point.name, name, why, nominal, band(known), open_loop))
    units = scenario.units.signals
    load = f"({units['load']})" if " " in units["load"] else units["load"]
    unit = f"{units['error']}/{load}"
    return LoopMargins(
        rows, scenario.simulation.sample_time_s, scenario.plant.name, unit, machines.size - 1
    )


def _at(
    scenario: Scenario, about: Steady, own: Controllers, lane: int, machine: Machines
) -> list[tuple[str, Json, OpenLoop | None]]:
    """Of each axis why it has no margins, else its numbers and its loop."""
    every, axes = scenario.simulation.sample_time_s, scenario.machine.axes
    if why := _why(scenario, about, own, lane, machine):
        return [(why, {}, None)] * len(axes)
    found: list[tuple[str, Json, OpenLoop | None]] = []
    for loop, of_load in loops(about, own, lane):
        if np.abs(loop.transfer(LOOKED_AT)).max() < NOTHING:
            found.append((HELD if loop.c.any() else OPEN, {}, None))
        else:
            found.append(("", numbers(margins(loop), every, largest(of_load)), loop))
    return found


def _why(scenario: Scenario, about: Steady, own: Controllers, lane: int, machine: Machines) -> str:
    """Why a loop cannot be linearised at a point; "" where it can."""
    if not about.found[lane]:
        return "no steady motion was found there, so that the loop cannot be linearised"
    pairs = zip(scenario.machine.axes, scenario.machine.drives, machine.true, strict=True)
    for (name, drive, parameters), command in zip(pairs, about.commands[lane], strict=True):
        low, high = drive.largest_commands(parameters, largest_command(scenario.limits.of(name)))
        if not low <= command <= high:
            unit = drive.units["command"]
            return f"it takes {command:.4g} {unit} of {high:.4g} {unit} to move so"
    if not own.found[lane]:
        return "the law was not found to hold it there, so that it cannot be linearised"
    return ""
