"""Test vectors: inputs, and the commands of the design's own runtime, with a tolerance.

Deterministic: the same design gives the same numbers.
"""

from collections.abc import Callable, Iterator
from contextlib import suppress
from itertools import chain
from typing import NamedTuple

import numpy as np

from hfc_design.controllers.controller import FOLLOWED, AxisLaw, PathView, View
from hfc_design.controllers.kind import needed
from hfc_design.controllers.rules import identifier
from hfc_design.core.numbers import Scalar
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.files.pairing import axes_of, own_scenario
from hfc_design.formats.deployment import single_precision, test_inputs
from hfc_design.formats.laws import NO_CODE, of_path
from hfc_design.runtime import Controller, Machine

#: What is told of the path of a machine.
PATH = ("tangent_x", "tangent_y", "curvature", "contour_error")


#: Samples in which a signal shows that is used at all, nearly always.
SOON = 50


class Vectors(NamedTuple):
    """Samples of a controller; of a machine of several axes those of each, one after the other."""

    axes: tuple[str, ...]  # ("",) of a single one
    signals: tuple[str, ...]  # that each axis tells
    path: tuple[str, ...]  # what is told of the path
    resets: tuple[bool, ...]  # (samples,) whether all is forgotten before it
    inputs: list[list[float]]  # (samples, axes x signals + path)
    commands: list[list[float]]  # (samples, axes)
    tolerance: single_precision.Tolerance

    @property
    def columns(self) -> list[str]:
        """Names of all columns, inputs before commands."""
        heads = [f"{axis}." if axis else "" for axis in self.axes]
        told = [f"{head}{identifier(name)}" for head in heads for name in self.signals]
        commands = [f"{head}command" for head in heads]
        return ["reset", "float", *told, *(f"path.{x}" for x in self.path), *commands]

    def largest(self, axis: str, name: str) -> float:
        """How large a signal of an axis gets, or its "command"."""
        k = self.axes.index(axis)
        if name == "command":
            return max(abs(row[k]) for row in self.commands)
        place = k * len(self.signals) + self.signals.index(name)
        return max(abs(row[place]) for row in self.inputs)

    @property
    def rows(self) -> list[list[float]]:
        """What stands in these columns."""
        each = zip(self.resets, self.tolerance.alike, self.inputs, self.commands, strict=True)
        return [[int(reset), int(alike), *given, *told] for reset, alike, given, told in each]


def vectors(design: Design, law: AxisLaw | None = None) -> Vectors:
    """The vectors of a design, or of the part of one axis; ``law`` as of ``runtime.Controller``."""
    kind = design.kind
    axes = (design.axis or "axis",) if kind.law else axes_of(design)
    names = tuple(kind.reads(design.controller)) if kind.reads else ()
    if own := design.connected:
        names = tuple(own.units)
        law = _connected_law(design, law) if kind.law else None
    path = PATH[: len(of_path(design))]
    inputs = _inputs(design, axes, names, len(path))
    views = [_view(row, axes, names) for row in inputs]
    commands = _commands(design, axes, views, law)

    near, far = (
        [*tried(np.array(inputs))]
        for tried in (single_precision.rounded, single_precision.disturbed)
    )
    rows = np.stack([*near, *far], axis=-1)  # (samples, inputs, tries)
    stepped = _unrated(design) if design.connected else design
    in_single = single_precision.commands(
        stepped, axes, rows, lambda row: _view([*row], axes, names), law
    )
    found = single_precision.tolerance(
        np.array(commands), in_single[: len(near)], in_single[len(near) :]
    )
    resets = tuple(k in test_inputs.RESETS for k in range(len(inputs)))
    return Vectors(("",) if kind.law else axes, names, path, resets, inputs, commands, found)


def _connected_law(design: Design, law: AxisLaw | None) -> AxisLaw:
    """The law of a connected design, or another one, with what connects it."""
    plain = needed(design.kind.law, design, NO_CODE)
    limit = design.limits.of(design.axis).command
    found: AxisLaw = design.connected.around(law or plain(design.controller, limit))
    return found


def _unrated(design: Design) -> Design:
    """A connected design, which keeps to a rate inside, without one around it."""
    return design.model_copy(update={"limits": design.limits.without_rate()})


def deviation(design: Design, found: Vectors) -> float:
    """The largest difference of the vectors' commands, of another law, from the design's own."""
    axes = (design.axis or "axis",) if design.kind.law else found.axes
    views = [_view(row, axes, found.signals) for row in found.inputs]
    exact = np.array(_commands(design, axes, views, None))
    return float(np.abs(np.array(found.commands) - exact).max())


def of_the_last_digit(design: Design, found: Vectors) -> float:
    """The largest difference of commands where all inputs are off by a last digit of theirs.

    What learns may make much of that, as of the last digit of an ``EXP`` that is another one's.
    """
    axes = (design.axis or "axis",) if design.kind.law else found.axes
    told, random = np.array(found.inputs), np.random.default_rng(0)
    told *= 1.0 + 2.0**-52 * random.choice([-1.0, 1.0], told.shape)
    views = [_view(row, axes, found.signals) for row in told.tolist()]
    off = np.array(_commands(design, axes, views, None)) - np.array(found.commands)
    return float(np.abs(off).max())


def unused(design: Design, found: Vectors) -> set[str]:
    """The signals that no command depends on, as where their gains are 0."""
    axes = (design.axis or "axis",) if design.kind.law else found.axes
    count, names = len(found.signals), []
    told = np.array(found.inputs)
    for k, name in enumerate(found.signals):
        without = told.copy()
        without[:, k : count * len(axes) : count] = 0.0
        for most in (SOON, len(told)):  # nearly always it shows soon
            views = [_view(row, axes, found.signals) for row in without[:most].tolist()]
            if _commands(design, axes, views, None) != found.commands[:most]:
                break
        else:
            names.append(name)
    return {*names}


def _commands(
    design: Design, axes: tuple[str, ...], views: list[View], law: AxisLaw | None
) -> list[list[float]]:
    """(samples, axes) what the runtime commands."""
    if design.connected:
        law = law or (_connected_law(design, None) if design.kind.law else None)
        design = _unrated(design)
    if design.kind.law is not None:
        one = Controller(design, law=law)
        return _stepped(one.reset, lambda view: [one.step(view.axes[0])], views)
    machine = Machine(design, axes)

    def step(view: View) -> list[float]:
        told = dict(zip(axes, view.axes, strict=True))
        return list(machine.step(told, view.path).values())

    return _stepped(machine.reset, step, views)


def _stepped(
    reset: Callable[[], None], step: Callable[[View], list[float]], views: list[View]
) -> list[list[float]]:
    found = []
    for k, view in enumerate(views):
        if k in test_inputs.RESETS:
            reset()
        found.append(step(view))
    return found


def _inputs(
    design: Design, axes: tuple[str, ...], names: tuple[str, ...], path: int
) -> list[list[float]]:
    sizes = test_inputs.reach(design.controller, axes, design.limits.commands(axes))
    for axis, name, most in _moved(design):
        own = sizes[axis if axis in axes else axes[0]]
        own[name] = max(own.get(name, 0.0), most)
    parts = []
    for k, (axis, own) in enumerate(sizes.items()):
        if design.connected:
            own["reference"] = 3.0 * own.get("error", 1.0)
        rows = test_inputs.driven(names, own, str(k))
        if told := design.connected:
            fed_back = told.fed_back.get(axis) or next(iter(told.fed_back.values()))
            rows = test_inputs.connected(rows, names, fed_back, own)
        parts.append(rows)
    parts += [test_inputs.path(sizes[axes[0]], path)] if path else []
    return [list(chain.from_iterable(row)) for row in zip(*parts, strict=True)]


def _moved(design: Design) -> Iterator[tuple[str, str, float]]:
    """Axis, signal, and how far that goes in the motions that a design was made for."""
    with suppress(UserError):  # they cannot be told here
        scenario = own_scenario(design, design.name)
        for motion in scenario.each_motion():
            for one, own in zip(scenario.plant.each(), motion.samples().axes, strict=True):
                told = {one.drive.position: own.reference, one.drive.velocity: own.reference_rate}
                told |= {name: getattr(own, name) for name in FOLLOWED}
                for name, x in told.items():
                    if x is not None and design.axis in ("", one.name):
                        yield one.name, name, float(np.abs(x).max())


def _view(row: list[Scalar], axes: tuple[str, ...], names: tuple[str, ...]) -> View:
    """A row of the inputs as the runtime takes it."""
    count = len(names)
    told = [row[k * count : (k + 1) * count] for k in range(len(axes))]
    way = row[len(axes) * count :]
    path = PathView((way[0], way[1]), way[2], way[3] if way[3:] else 0.0) if way else None
    return View(tuple(dict(zip(names, each, strict=True)) for each in told), path)
