"""Samples for exported C on microcontrollers, and what the runtime makes of them."""

import numpy as np
from wandering import wandering

from hfc_design.controllers.controller import PathView
from hfc_design.files.design import builtin_designs
from hfc_design.files.loop_setup import axes_of, load_design
from hfc_design.formats import code
from hfc_design.formats.laws import of_path
from hfc_design.motion.contour import local_error
from hfc_design.runtime import Controller, Machine

COUNT = 1000
#: Every built-in design that C is made of; where the axes differ, each of them.
DESIGNS = {part.name: part for x in builtin_designs() for part in load_design(x).by_axis().values()}
#: Of an axis, and with memory for what they learn within two kilobytes.
ON_UNO = [x for x, own in DESIGNS.items() if own.kind.law and own.controller.kind != "neural"]


def case(design):
    """Samples (COUNT, numbers) in single precision, and the commands of the runtime for them.

    Of a machine the signals of each axis, then tangent, curvature and contour error of the path
    where that is seen. Two samples are faulty. The signals are halved until less than a quarter of
    the commands is at the limit.
    """
    axes = () if design.kind.law else axes_of(design)
    signals = np.stack([wandering(design, k, COUNT) for k in range(len(axes) or 1)], axis=1)
    while True:
        errors = signals[:, :, list(code.signals(design)).index("error")]
        samples = np.concatenate([signals.reshape(COUNT, -1), _path(design, errors)], axis=1)
        samples = samples.astype(np.float32)
        samples[500, 0], samples[600, -1] = np.nan, np.inf
        expected = _of_the_runtime(design, axes, samples.astype(float))
        if np.mean(np.abs(expected) == design.limits.command) < 0.25:
            return samples, expected
        signals /= 2.0


def _path(design, errors):
    if design.kind.law or not of_path(design):
        return np.empty((COUNT, 0))
    angle = np.arange(COUNT) / 30.0
    bent = np.where(np.arange(COUNT) < 700, 0.002, -0.001)
    path = np.stack([np.cos(angle), np.sin(angle), bent], axis=1)
    off = [local_error(*row) for row in np.concatenate([-errors, path], axis=1)]
    return np.column_stack([path, off])


def _of_the_runtime(design, axes, samples):
    names = list(code.signals(design))
    if not axes:
        controller = Controller(design)
        rows = (dict(zip(names, row, strict=True)) for row in samples.tolist())
        return np.array([[controller.step(row)] for row in rows])
    controller, found = Machine(design, axes), []
    for row in samples.tolist():
        own = np.array(row[: len(axes) * len(names)]).reshape(len(axes), -1).tolist()
        told = {x: dict(zip(names, y, strict=True)) for x, y in zip(axes, own, strict=True)}
        rest = row[len(axes) * len(names) :]
        path = PathView(tuple(rest[:2]), rest[2], rest[3]) if rest else None
        found.append(list(controller.step(told, path).values()))
    return np.array(found)
