"""Test vectors: inputs, the commands that ``runtime`` gives for them, and a tolerance.

The same design always gives the same vectors.
"""

from collections.abc import Iterator
from contextlib import suppress
from itertools import chain
from typing import NamedTuple

import numpy as np

from hfc_design.controllers.controller import FOLLOWED, AxisLaw, PathView, View
from hfc_design.controllers.kind import require
from hfc_design.controllers.rules import identifier
from hfc_design.core.numbers import Scalar
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.files.loop_setup import axes_of, own_scenario
from hfc_design.formats.deployment import single_precision, test_inputs
from hfc_design.formats.laws import NO_CODE, of_path
from hfc_design.runtime import Controller, Machine

#: Number of samples within which nearly every signal that is used changes a command.
SOON = 50


class Vectors(NamedTuple):
    """Samples of a controller; for a machine, the columns of one axis follow those of another."""

    axes: tuple[str, ...]  # names; ("",) for the controller of one axis
    signals: tuple[str, ...]  # inputs of each axis
    path: tuple[str, ...]  # inputs that describe the path
    resets: tuple[bool, ...]  # (samples,) whether the memory is reset before the sample
    inputs: list[list[float]]  # (samples, axes x signals + path)
    commands: list[list[float]]  # (samples, axes)
    tolerance: single_precision.Tolerance

    @property
    def columns(self) -> list[str]:
        """Names of all columns: "reset", "float", inputs, commands."""
        heads = [f"{axis}." if axis else "" for axis in self.axes]
        inputs = [f"{head}{identifier(name)}" for head in heads for name in self.signals]
        commands = [f"{head}command" for head in heads]
        return ["reset", "float", *inputs, *(f"path.{x}" for x in self.path), *commands]

    def largest(self, axis: str, name: str) -> float:
        """Return the largest magnitude of a signal of an axis, or of its "command"."""
        k = self.axes.index(axis)
        if name == "command":
            return max(abs(row[k]) for row in self.commands)
        place = k * len(self.signals) + self.signals.index(name)
        return max(abs(row[place]) for row in self.inputs)

    @property
    def rows(self) -> list[list[float]]:
        """Values of all columns, row by row."""
        each = zip(self.resets, self.tolerance.alike, self.inputs, self.commands, strict=True)
        return [[int(reset), int(alike), *given, *outputs] for reset, alike, given, outputs in each]


def vectors(design: Design, law: AxisLaw | None = None) -> Vectors:
    """Return the test vectors of a design (or one axis); for ``law`` see ``runtime.Controller``."""
    kind, axes = design.kind, _axes(design)
    names = tuple(kind.reads(design.controller)) if kind.reads else ()
    if connection := design.connected:
        names = tuple(connection.units)
        law = _connected_law(design, law) if kind.law else None
    path = tuple(name.removeprefix("path_") for name in of_path(design))
    inputs = _inputs(design, axes, names, len(path))
    commands = _commands(design, names, inputs, law)

    tried = (single_precision.rounded, single_precision.disturbed)
    near, far = ([*off(np.array(inputs))] for off in tried)
    rows = np.stack([*near, *far], axis=-1)  # (samples, inputs, tries)
    in_single = single_precision.commands(
        _unrated(design), axes, rows, lambda row: _view([*row], axes, names), law
    )
    count = len(near)
    tolerance = single_precision.tolerance(np.array(commands), in_single[:count], in_single[count:])
    resets = tuple(k in test_inputs.RESETS for k in range(len(inputs)))
    heads = ("",) if kind.law else axes
    return Vectors(heads, names, path, resets, inputs, commands, tolerance)


def _axes(design: Design) -> tuple[str, ...]:
    """Return the axes that the controller commands; for one axis its name, or "axis"."""
    return (design.axis or "axis",) if design.kind.law else axes_of(design)


def _connected_law(design: Design, law: AxisLaw | None) -> AxisLaw:
    """Return ``law``, or else the design's own law, with the connection of the design around it."""
    plain = require(design.kind.law, design, NO_CODE)
    limit = design.limits.of(design.axis).command
    connected: AxisLaw = design.connected.around(law or plain(design.controller, limit))
    return connected


def _unrated(design: Design) -> Design:
    """Return the design; if connected, without rate limit, which its connection already has."""
    if not design.connected:
        return design
    return design.model_copy(update={"limits": design.limits.without_rate()})


def deviation(design: Design, vectors: Vectors) -> float:
    """Return how far commands in ``vectors``, made with another law, are from the design's."""
    return _furthest(vectors, _commands(design, vectors.signals, vectors.inputs))


def of_the_last_digit(design: Design, vectors: Vectors) -> float:
    """Return the largest change of a command if all inputs change by one in their last digit.

    A controller that learns may amplify such a change, and in the same way a difference in the last
    digit between two implementations of ``EXP``.
    """
    inputs, random = np.array(vectors.inputs), np.random.default_rng(0)
    inputs *= 1.0 + 2.0**-52 * random.choice([-1.0, 1.0], inputs.shape)
    return _furthest(vectors, _commands(design, vectors.signals, inputs.tolist()))


def _furthest(vectors: Vectors, commands: list[list[float]]) -> float:
    return float(np.abs(np.array(commands) - np.array(vectors.commands)).max())


def unused(design: Design, vectors: Vectors) -> set[str]:
    """Return the signals that no command depends on, for example because their gains are 0."""
    count, names = len(vectors.signals), set()
    for k, name in enumerate(vectors.signals):
        without = np.array(vectors.inputs)
        without[:, k : count * len(_axes(design)) : count] = 0.0
        samples = (SOON, len(without))  # the first ones are usually enough
        if all(
            _commands(design, vectors.signals, without[:most].tolist()) == vectors.commands[:most]
            for most in samples
        ):
            names.add(name)
    return names


def _commands(
    design: Design, names: tuple[str, ...], inputs: list[list[float]], law: AxisLaw | None = None
) -> list[list[float]]:
    """Return the commands (samples, axes) of the runtime, which is reset before ``RESETS``."""
    axes = _axes(design)
    one: Controller | Machine
    if design.kind.law is None:
        one = machine = Machine(_unrated(design), axes)
    else:
        if design.connected:
            law = law or _connected_law(design, None)
        one = controller = Controller(_unrated(design), law=law)
    commands = []
    for k, row in enumerate(inputs):
        if k in test_inputs.RESETS:
            one.reset()
        view = _view(row, axes, names)
        if design.kind.law is None:
            each = dict(zip(axes, view.axes, strict=True))
            commands.append([*machine.step(each, view.path).values()])
        else:
            commands.append([controller.step(view.axes[0])])
    return commands


def _inputs(
    design: Design, axes: tuple[str, ...], names: tuple[str, ...], path: int
) -> list[list[float]]:
    sizes = test_inputs.input_ranges_of(design.controller, axes, design.limits.commands(axes))
    for axis, name, most in _moved(design):
        sizes_of_axis = sizes[axis if axis in axes else axes[0]]
        sizes_of_axis[name] = max(sizes_of_axis.get(name, 0.0), most)
    parts = []
    for k, (axis, sizes_of_axis) in enumerate(sizes.items()):
        if connection := design.connected:
            sizes_of_axis["reference"] = 3.0 * sizes_of_axis.get("error", 1.0)
        rows = test_inputs.driven(names, sizes_of_axis, str(k))
        if connection:
            fed_back = connection.fed_back.get(axis) or next(iter(connection.fed_back.values()))
            steps = connection.steps.get(axis) or next(iter(connection.steps.values()))
            rows = test_inputs.connected(rows, names, fed_back, sizes_of_axis, steps)
        parts.append(rows)
    parts += [test_inputs.path(sizes[axes[0]], path)] if path else []
    return [list(chain.from_iterable(row)) for row in zip(*parts, strict=True)]


def _moved(design: Design) -> Iterator[tuple[str, str, float]]:
    """Yield (axis, signal, largest magnitude) for the motions that a design was made for."""
    with suppress(UserError):  # the scenario cannot be run here
        scenario = own_scenario(design, design.name)
        for motion in scenario.each_motion():
            for one, axis_samples in zip(scenario.plant.each(), motion.samples().axes, strict=True):
                followed = {one.drive.position: axis_samples.reference}
                followed[one.drive.velocity] = axis_samples.reference_rate
                followed |= {name: getattr(axis_samples, name) for name in FOLLOWED}
                for name, x in followed.items():
                    if x is not None and design.axis in ("", one.name):
                        yield one.name, name, float(np.abs(x).max())


def _view(row: list[Scalar], axes: tuple[str, ...], names: tuple[str, ...]) -> View:
    """Return a row of inputs as the view that the runtime takes."""
    count = len(names)
    per_axis = [row[k * count : (k + 1) * count] for k in range(len(axes))]
    way = row[len(axes) * count :]
    path = PathView((way[0], way[1]), way[2], way[3] if way[3:] else 0.0) if way else None
    return View(tuple(dict(zip(names, each, strict=True)) for each in per_axis), path)
