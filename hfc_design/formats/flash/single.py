"""A controller in single precision: the same law on float32, to tell what that changes.

C in float sums in another order, so that its commands are about as far off as these, not equal.
"""

from collections.abc import Iterable
from math import exp, isfinite, tanh

import numpy as np

from hfc_design.controllers.controller import AxisLaw, Controller, PerAxis, View, rate_limited
from hfc_design.core.numbers import SCALARS, Plain
from hfc_design.files.design import Design
from hfc_design.formats.flash.driving import RESETS

#: Functions that the law asks for whose results would be of Python's floats.
SINGLE = SCALARS._replace(
    bell=lambda rate, distance: np.float32(exp((-rate * distance) * distance)),
    tanh=lambda x: np.float32(tanh(x)),
)


def single(value: Plain) -> Plain:
    """All real numbers in tables and records rounded to single precision."""
    if isinstance(value, float):
        return np.float32(value)
    if isinstance(value, dict):
        return {key: single(part) for key, part in value.items()}
    if hasattr(value, "_fields"):
        return type(value)(*map(single, value))
    if isinstance(value, list | tuple):
        return type(value)(map(single, value))
    if isinstance(value, np.ndarray) and value.dtype.kind == "f":
        return value.astype(np.float32)
    return value


def commands(
    design: Design, axes: tuple[str, ...], views: Iterable[View], law: AxisLaw | None = None
) -> list[list[float]]:
    """(samples, axes) commands of a design; the views are in single precision.

    ``law`` as of ``runtime.Controller``. Where a command would not be finite the past is kept, as
    in C.
    """
    controller = design.commanding(axes)
    if law is not None:
        own: Controller = PerAxis(design.kind.name, (law,))
        controller = rate_limited(own, design.limits.commands(axes), design.changes(axes))
    gains = single(design.kind.gains(design.controller))
    found: list[list[float]] = []
    with np.errstate(all="ignore"):
        for k, view in enumerate(views):
            if k in RESETS:
                memory = single(controller.initial_memory(0.0))
            told, after = controller.step(SINGLE, gains, memory, view)
            found.append(list(map(float, told)))
            if all(map(isfinite, found[-1])):
                memory = after
    return found
