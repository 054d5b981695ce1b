"""Margins of a design's loop as simulated, at the speeds of a scenario's motions.

``loop_margins`` computes them exactly for one design. ``AskedMargins`` computes those that a
scenario requires for a population, before it is simulated. The machine with its sensors is the same
for all individuals: its response is computed once, at some frequencies. Values between them are
interpolated, so slightly more is required than the scenario states. A *lane* is one loop, that of
one individual on one machine at one operating point.
"""

from copy import copy
from functools import partial
from typing import Any, NamedTuple

import jax
import numpy as np

from hfc_design.controllers.controller import Controller
from hfc_design.core.numbers import SAME, Floats, Gains, Json, Mask, storable
from hfc_design.files.design import AnyDesign
from hfc_design.files.loop_setup import controller_of, load_design, machine, with_converter
from hfc_design.files.named_scenario import AnyScenario, load_scenario
from hfc_design.files.scenario import Scenario
from hfc_design.files.stress import MODES
from hfc_design.motion.samples import Samples
from hfc_design.simulation.closed_loop import Loop, closed_loop
from hfc_design.simulation.linearised import Controllers, Steady, controlled, loops, steady
from hfc_design.simulation.population import Machines, one_machine, own_code_of, standing
from hfc_design.simulation.sensors import largest_command
from hfc_design.stability.frequency import response_units
from hfc_design.stability.margins import (
    ASKED,
    GOALS,
    OpenLoop,
    largest,
    margins,
    sampled_margins,
    swung,
)
from hfc_design.stability.report import At, LoopMargins, band

#: Number of machines beside the nominal one from which a band of margins is computed.
BAND = 20
#: Factor by which two speeds of a path may differ and still count as equal.
ALIKE = 1.01
#: A speed below this share of the highest speed of a motion counts as rest.
STANDS = 0.01
#: Angles at which the response of a loop is checked, and the largest magnitude that counts as 0.
LOOKED_AT, NOTHING = np.geomspace(1e-3, 3.0, 9), 1e-9
#: Angle at which the compliance is the static one.
SLOWEST = 1e-6
#: Frequencies in a search [half the sampling rate], and factor by which more is required.
FREQUENCIES, STRICTER = np.geomspace(1e-3, 1.0, 64), 1.01
#: Poles of larger magnitude have narrow peaks, which are sought at these half widths from the pole.
LIGHT, ABOUT = 0.9, np.linspace(-1.0, 1.0, 5)
#: Largest value of ``swung`` that a search allows: how near to -1 a mode may lead a loop.
NEAR = 0.6
#: Samples over which the growth of an unstable loop is counted, and growth that is only rounding.
LONG, ROUNDED = 1000, 1e-6
#: Error beyond the outermost terms of every rule table, in the unit of the table.
FAR_OFF = 1e6
#: Ranks of the machines that are checked, as shares of the number that may fail under a stress.
LIMIT = np.array([0.55, 0.7, 0.85, 1.0])
HELD = "a small command moves no measured signal there: friction or backlash holds it"
CANNOT = " cannot be linearised"
OPEN = "the law does not respond to a small error there, so the loop is open"


class Point(NamedTuple):
    """A steady motion of a machine."""

    name: str
    row: Samples  # one column of the samples
    speeds: tuple[float, ...]  # of each axis [of its position, per s]


def operating_points(scenario: Scenario) -> list[Point]:
    """Return operating points: rest, and where motions are slowest and fastest; each speed once."""
    points: dict[tuple[float, ...], Point] = {}
    for motion in scenario.each_motion():
        samples, name = motion.samples(), motion.name.removeprefix(f"{scenario.name}.")
        rates = np.array([axis.reference_rate for axis in samples.axes])
        sizes = np.linalg.norm(rates, axis=0)
        # If this speed lasts for a while, as on a circle, a place is chosen where all axes move.
        alike = np.abs(rates).min(axis=0) / max(sizes.max(), np.finfo(float).tiny)
        slow, fast = sizes <= sizes.min() * ALIKE, sizes * ALIKE >= sizes.max()
        slowest, fastest = (int(np.where(some, alike, -1.0).argmax()) for some in (slow, fast))
        places = {"at rest": 0, "slowest": slowest, "fastest": fastest}
        for where, k in places.items():
            still = where == "at rest" or sizes[k] <= STANDS * sizes.max()
            speeds = tuple(float(f"{0.0 if still else x:.6g}") for x in rates[:, k])
            one = f"{abs(speeds[0]):g} {motion.units.signals['error_rate']}"
            speed = f"{name} {where}" if len(speeds) > 1 else one
            row = steady_row(motion, samples, k, speeds)
            points.setdefault(speeds, Point(speed if any(speeds) else "at rest", row, speeds))
    return sorted(points.values(), key=lambda one: np.linalg.norm(one.speeds))


def steady_row(motion: Scenario, samples: Samples, k: int, speeds: tuple[float, ...]) -> Samples:
    """Return column ``k`` for a machine that always moves at ``speeds``, under constant load."""

    def first_of(leaf: Floats) -> Floats:
        return np.asarray(leaf, float)[..., k]

    axes = []
    for name, axis, speed in zip(motion.machine.axes, samples.axes, speeds, strict=True):
        one = jax.tree.map(first_of, axis)
        load = motion.load.of(name).constant
        rate = {"reference_rate": np.float64(speed)}
        if one.reference_acceleration is not None:
            rate["reference_acceleration"] = np.float64(0.0)
        axes.append(one._replace(loads=0.0 * one.loads + load, noise=0.0 * one.noise, **rate))
    whole = samples._replace(axes=(), sample_time=(), start=(), copy_start=())
    rest = {"sample_time": samples.sample_time, "start": samples.start}
    return jax.tree.map(first_of, whole)._replace(axes=tuple(axes), **rest)


def near(loop: Loop, machines: Machines, points: list[Point]) -> Steady:
    """Return the machines without a controller, each linearised at all points in turn."""
    count = machines.size
    true = jax.tree.map(lambda leaf: np.repeat(leaf, len(points)), machines.actual)
    rows = jax.tree.map(
        lambda *leaves: np.stack([np.asarray(x, float) for x in leaves] * count),
        *(point.row for point in points),
    )
    return steady(loop, machines.nominal, true, rows, np.array([x.speeds for x in points] * count))


def loop_margins(
    design: AnyDesign, scenario: AnyScenario, machines: Machines | None = None
) -> LoopMargins:
    """Return the margins of a design at the operating points of a scenario.

    ``machines`` are the nominal one and others, whose margins are given as a band; None: only the
    nominal machine.

    Raises:
        UserError: design and scenario do not fit, or a user's own part cannot be linearised.
    """
    design = load_design(design)
    scenario = with_converter(load_scenario(scenario), design)
    controller, gains = controller_of(design, scenario)
    loop = closed_loop(scenario, controller)
    if machines is None:
        machines = one_machine(machine(design, scenario).values())
    machines = machines.take(np.arange(min(machines.size, BAND + 1)))
    with own_code_of(loop, CANNOT):
        points = operating_points(scenario)
        about = near(loop, standing(machines, scenario, loop), points)
        lanes = np.zeros(len(about.exists), int)
        every = jax.tree.map(lambda leaf: np.take(leaf, lanes, axis=-1), gains)
        controllers = controlled(loop, machines.nominal, every, about)
    rows, count, axes = [], len(points), scenario.machine.axes
    for n, point in enumerate(points):
        each = [
            _at(scenario, about, controllers, n + k * count, machines.take(k))
            for k in range(machines.size)
        ]
        for axis, of_axis in zip(axes, zip(*each, strict=True), strict=True):
            (why, nominal, open_loop), *others = of_axis
            known = [margin_values for _, margin_values, _ in others if margin_values]
            name = axis if len(axes) > 1 else ""
            rows.append(At(point.name, name, why, nominal, band(known), open_loop))
    unit = response_units(scenario.units.signals)[1]
    return LoopMargins(
        rows, scenario.simulation.sample_time_s, scenario.plant.name, unit, machines.size - 1
    )


def _at(
    scenario: Scenario, about: Steady, controllers: Controllers, lane: int, machine: Machines
) -> list[tuple[str, Json, OpenLoop | None]]:
    """Return for each axis why it has no margins, or "", the margins, and the open loop."""
    every, axes = scenario.simulation.sample_time_s, scenario.machine.axes
    if why := _why(scenario, about, controllers, lane, machine):
        return [(why, {}, None)] * len(axes)
    entries: list[tuple[str, Json, OpenLoop | None]] = []
    for loop, of_load in loops(about, controllers, lane):
        if np.abs(loop.transfer(LOOKED_AT)).max() < NOTHING:
            entries.append((HELD if loop.c.any() else OPEN, {}, None))
        else:
            soft = zip(("compliance", "compliance_static"), largest(of_load), strict=True)
            entries.append(("", margins(loop, every)._asdict() | storable(dict(soft)), loop))
    return entries


def _why(
    scenario: Scenario, about: Steady, controllers: Controllers, lane: int, machine: Machines
) -> str:
    """Return the reason why a loop cannot be linearised at a point; "" if it can."""
    if not about.exists[lane]:
        gap = "with its backlash " * any(getattr(x, "backlash", 0.0) > 0.0 for x in machine.actual)
        return f"{gap}no steady motion was found there, so the loop cannot be linearised"
    pairs = zip(scenario.machine.axes, scenario.machine.drives, machine.actual, strict=True)
    for (name, drive, parameters), command in zip(pairs, about.commands[lane], strict=True):
        low, high = drive.largest_commands(parameters, largest_command(scenario.limits.of(name)))
        if not low <= command <= high:
            unit = drive.units["command"]
            return f"this motion needs {command:.4g} {unit} of {high:.4g} {unit}"
    if not controllers.exists[lane]:
        return "found no steady state of the law there, so it cannot be linearised"
    return ""


class AskedMargins:
    """The loop of a scenario on its nominal machine, and the margins that are required of it.

    ``rubbing`` are machines with the friction of a stress. Of these, the loops of the machines that
    must just pass (``_at_the_limit``) have to be stable too. With ``narrow``, as for finalists, the
    peaks of lightly damped poles between the frequencies count as well.
    """

    def __init__(
        self, scenario: Scenario, loop: Loop, rubbing: Machines | None = None, narrow: bool = False
    ):
        machines, points = one_machine(scenario.plant.values()), operating_points(scenario)
        last = len(points) - 1
        places = sorted({0, min(1, last), min(2, last), (last + 1) // 2, last})
        laws, met = places, [*range(len(places))]
        self._rest = len(places) if last > 0 else -1
        if last > 0:  # friction does not hold a trembling axis: law at rest, machine in motion
            laws, met = [*places, 0], [*met, 1]
        self._off = np.zeros(len(laws))
        if last > 0 and scenario.robust and scenario.stress.unknown_above_hz:
            # It is not at an error of 0 either: far from it the law may have other slopes.
            laws, met = [*laws, 0, 0, places[1], places[1]], [*met, *[1] * 4]
            self._off = np.append(self._off, [FAR_OFF, -FAR_OFF] * 2)
        with own_code_of(loop, CANNOT):
            self._machines = every = near(loop, machines, [points[k] for k in laws])
        every = jax.tree.map(lambda leaf: leaf[np.array(met)], every)
        self._loop, self._nominal, self._required = loop, machines.nominal, scenario.margins
        self._stress, self._narrow = scenario.stress if scenario.robust else None, narrow
        sliding = _at_the_limit(scenario, loop, rubbing) if rubbing else None
        if sliding is not None:  # lanes behind those of the points
            self._machines = jax.tree.map(lambda *x: np.concatenate(x), self._machines, sliding)
            self._off = np.append(self._off, np.zeros(len(sliding.exists)))
        self._every = scenario.simulation.sample_time_s
        poles = np.linalg.eigvals(every.a).ravel()
        light = poles[(poles.imag > 0.0) & (np.abs(poles) > LIGHT)]
        hz = [x.hz for x in scenario.stress.modes]
        unknown, highest = scenario.stress.modes_between(0.0, self._every)
        if 0.0 < unknown < highest:
            hz += [*np.geomspace(unknown, highest, MODES)]
        modes = 2.0 * np.pi * self._every * np.array(hz)
        static = [SLOWEST] if "compliance" in self._required else []
        self._angles = np.unique(np.r_[static, np.pi * FREQUENCIES, np.angle(light), modes])
        z = np.exp(1j * self._angles)[:, None, None]
        unit = np.eye(every.a.shape[-1])
        inputs = np.concatenate([every.b, every.e], axis=2)[:, None].astype(complex)
        states = np.linalg.solve(z * unit - every.a[:, None], inputs)
        #: (points, frequencies, signals, axes) response of the signals to commands, and to loads;
        #: that of the positions to both.
        self._answers, self._loaded = np.split(every.c[:, None] @ states, 2, axis=-1)
        self._moved = every.d[:, None] @ states

    def of(self, controller: Controller) -> "AskedMargins":
        """Return the same requirements for another controller."""
        clone = copy(self)
        clone._loop = self._loop._replace(controller=controller)
        return clone

    def broken(self, gains: Gains) -> Floats:
        """Return how much each individual misses requirements, (individuals,); 0: not at all."""
        every = self._near(gains)
        (*_, known, poles), places, each = every, len(self._machines.exists), []
        radius = np.where(known[:, 0], np.abs(poles).max(axis=1), 0.0).reshape(-1, places)
        grown = np.where(radius > 1.0 + ROUNDED, LONG * (radius - 1.0), 0.0)
        some = self._of_points(every)
        # Without required margins only stability is required.
        limits = self._required and self._required | {"modes": NEAR}
        margin_values = self._margins(*some) if limits else {}
        rest = np.arange(len(some[2]))[:, None] % len(self._answers) == self._rest
        for name, limit in limits.items():
            value, more = margin_values[name], name == "modes" or ASKED[name][1]
            with np.errstate(divide="ignore"):
                over = value / limit * STRICTER if more else limit * STRICTER / value
            over = np.where(rest & (name != "modes"), 0.0, over)  # only modes count there
            each.append(np.nan_to_num(over - 1.0, nan=0.0, posinf=np.inf))
        count = len(self._answers)
        worst = [one.max(axis=1, initial=0.0).reshape(-1, count).max(axis=1) for one in each]
        worst.append(grown[:, :count].max(axis=1))
        if grown.shape[1] > count:
            worst.append(grown[:, count:].max(axis=1))
        return np.asarray(sum(1.0 - 1.0 / (1.0 + one) for one in worst))

    def margins(self, gains: Gains) -> dict[str, Floats]:
        """Return each margin (individuals x points, axes); nan where a loop cannot be linearised.

        The margins of an unstable loop mean nothing.
        """
        return self._margins(*self._of_points(self._near(gains)))

    def _of_points(self, every: Any) -> Any:
        """Return the lanes (individuals x points) of leaves, without the ``rubbing`` machines."""
        lanes = np.arange(len(jax.tree.leaves(every)[0])) % len(self._machines.exists)
        return jax.tree.map(lambda leaf: leaf[lanes < len(self._answers)], every)

    def _near(self, gains: Gains) -> tuple[Steady, Controllers, Mask, Any]:
        """Return machines, controllers, which exist, and closed poles, (individuals x machines)."""
        points, count = len(self._machines.exists), jax.tree.leaves(gains)[0].shape[-1]
        every = jax.tree.map(lambda leaf: np.repeat(leaf, points, axis=-1), gains)
        machines: Steady = jax.tree.map(partial(_lanes, count=count), self._machines)
        with own_code_of(self._loop, CANNOT), np.errstate(all="ignore"):
            off = np.tile(self._off, count) if self._off.any() else None
            controllers = controlled(self._loop, self._nominal, every, machines, off)
        known = (controllers.exists & machines.exists)[:, None]
        return machines, controllers, known, _closed(machines, controllers)

    def _margins(
        self, machines: Steady, controllers: Controllers, known: Mask, poles: Any
    ) -> dict[str, Floats]:
        """Return each margin (lanes, axes); nan for lanes that are not ``known``."""
        with np.errstate(all="ignore"):
            through = _responses(controllers, self._answers, self._angles)
            whole = np.eye(through.shape[-1]) - through
            if "compliance" in self._required:
                pushed = _responses(controllers, self._loaded, self._angles)
                each = _lanes(self._moved, len(whole) // len(self._moved))
                moved, loaded = np.split(each, 2, axis=-1)
                soft = np.diagonal(loaded + moved @ np.linalg.solve(whole, pushed), 0, 2, 3)
            else:
                soft = np.zeros(whole.shape[:3])
            others = [np.delete(np.delete(whole, k, -1), k, -2) for k in range(whole.shape[-1])]
            sensitivity = np.stack([np.linalg.det(each) for each in others], axis=-1)
            sensitivity = sensitivity / np.linalg.det(whole)[..., None]
            values = sampled_margins(self._angles, self._every, sensitivity.swapaxes(1, 2))
            values |= {
                "sensitivity": _peaks(np.abs(sensitivity)),
                "closed_loop_peak": _peaks(np.abs(1.0 - sensitivity)),
                "compliance": _peaks(np.abs(soft)),
            }
            if self._narrow and known.shape[1] == 1:
                thin = _thin(machines, controllers, poles)
                values["sensitivity"] = np.fmax(values["sensitivity"], thin)
            near = np.tile(self._off[: len(self._answers)] == 0.0, len(whole) // len(self._answers))
            both = {}
            for name, (key, more, _) in ASKED.items():
                none = np.isnan(values[key]) & (not more)  # a margin without an end is unlimited
                both[name] = np.where(none, np.inf, values[key])
                if name in GOALS:
                    both[name] = np.where(near[:, None], both[name], np.nan)
            loop = (1.0 / sensitivity - 1.0).swapaxes(1, 2)  # (lanes, axes, frequencies)
            both["modes"] = self._swung(loop, values["crossover_hz"])
        return {name: np.where(known, each, np.nan) for name, each in both.items()}

    def _swung(self, loop: Any, crossover: Floats) -> Floats:
        """Return how near modes of the stress lead loops to -1, (lanes, axes), see ``swung``."""
        stress, hz = self._stress, self._angles / (2.0 * np.pi * self._every)
        nearest = np.zeros(loop.shape[:-1])
        if stress is None:
            return nearest
        lowest, highest = stress.modes_between(crossover, self._every)
        near = (hz >= lowest[..., None] * (1.0 - SAME)) & (hz <= highest * (1.0 + SAME))
        shares = [x / (1.0 - x) for x in stress.mode_inertia] + [-1.0] * stress.far_modes
        for share in shares:
            some = np.where(near, swung(loop, stress.mode_damping, share), 0.0)
            nearest = np.fmax(nearest, np.fmax.reduce(some, -1))
        for one in stress.modes:
            place = int(np.abs(hz - one.hz).argmin())
            nearest = np.fmax(nearest, swung(loop[..., place], one.damping, one.share))
        return nearest


def _at_the_limit(scenario: Scenario, loop: Loop, machines: Machines) -> Steady | None:
    """Return the machines that just have to pass, at the lowest speed; None if no motion moves.

    These have the ranks ``LIMIT`` by the largest pole of a machine without control, worst first.
    """
    pairs = zip(scenario.motions, scenario.nominal_only, strict=False)  # no motions: it is one
    of_all = {"motions": tuple(motion for motion, alone in pairs if not alone)}
    points = operating_points(scenario.model_copy(update=of_all))
    if not (moving := [point for point in points if any(point.speeds)]):
        return None
    about = near(loop, standing(machines, scenario, loop), moving[:1])
    largest_poles = np.abs(np.linalg.eigvals(about.a)).max(axis=1)
    # Where none leaves steady sliding, all have the pole 1 of an integrator, give or take rounding.
    hard = np.argsort(-largest_poles.round(9), kind="stable")
    some = hard[(LIMIT * (1.0 - scenario.stress.share) * len(hard)).astype(int)]
    return jax.tree.map(lambda leaf: leaf[some], about)


def _lanes(each: Floats, count: int) -> Floats:
    """Return the values of the points for lanes (individuals x points), ``count`` individuals."""
    return np.tile(each, (count, *[1] * (each.ndim - 1)))


def _closed(machines: Steady, controllers: Controllers) -> Any:
    """Return the poles (lanes, poles) of the closed loops; a magnitude above 1 is unstable."""
    moved, given = machines.a + machines.b @ controllers.d @ machines.c, machines.b @ controllers.c
    whole = np.block([[moved, given], [controllers.b @ machines.c, controllers.a]])
    return np.linalg.eigvals(np.nan_to_num(whole))


def _thin(machines: Steady, controllers: Controllers, closed: Any) -> Floats:
    """Return the largest |1 / (1 + L)| near lightly damped closed poles, (lanes, 1); 0: none."""
    begun = np.hstack([np.linalg.eigvals(np.nan_to_num(x)) for x in (machines.a, controllers.a)])
    angles = np.angle(closed)[..., None] + (1.0 - np.abs(closed))[..., None] * ABOUT
    z = np.exp(1j * angles.reshape(len(closed), -1, 1))
    sizes = np.abs(z - begun[:, None]).prod(axis=2) / np.abs(z - closed[:, None]).prod(axis=2)
    light = (closed.imag > 0.0) & (np.abs(closed) > LIGHT)
    sizes = np.where(light, sizes.reshape(angles.shape).max(axis=2), 0.0)
    return np.asarray(sizes.max(axis=1, keepdims=True))


def _peaks(sizes: Floats) -> Floats:
    """Return the maxima (lanes, axes) over frequencies, of parabolas through each three values."""
    before, here, after = (np.log(sizes[:, k : k - 2 or None]) for k in range(3))
    top, steep, bent = here, 0.5 * (after - before), after + before - 2.0 * here
    top = here - np.where((bent < 0.0) & (np.abs(steep) <= -bent), 0.5 * steep**2 / bent, 0.0)
    return np.maximum(np.exp(top.max(axis=1)), sizes.max(axis=1))


def _responses(controllers: Controllers, answers: Floats, angles: Floats) -> Floats:
    """Return the responses of new commands to commands, (lanes, frequencies, axes, axes)."""
    z, unit = np.exp(1j * angles)[:, None, None], np.eye(controllers.a.shape[-1])
    a, c = (x.swapaxes(1, 2)[:, None] for x in (controllers.a, controllers.c))
    inner = np.linalg.solve(z * unit - a, c.astype(complex)).swapaxes(2, 3)
    rows = controllers.d[:, None] + inner @ controllers.b[:, None]
    return (rows.reshape(-1, len(answers), *rows.shape[1:]) @ answers).reshape(*rows.shape[:3], -1)
