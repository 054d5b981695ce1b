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
    design: Design,
    axes: tuple[str, ...],
    views: Iterable[View],
    towards: float,
    law: AxisLaw | None = None,
) -> list[list[float]]:
    """(samples, axes) commands of a design whose inputs are off by a rounding ``towards``.

    0 is no number to be off towards: inputs are the nearest ones of single precision. ``law`` as of
    ``runtime.Controller``. Where the command would not be finite the past is kept, as in C.
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
            seen = _shifted(single(view), towards) if towards else single(view)
            told, after = controller.step(SINGLE, gains, memory, seen)
            found.append(list(map(float, told)))
            if all(map(isfinite, found[-1])):
                memory = after
    return found


def _shifted(value: Plain, towards: float) -> Plain:
    """Each number the next one of single precision ``towards`` another; 0 stays."""
    if isinstance(value, np.float32):
        return np.nextafter(value, np.float32(towards)) if value else value
    if isinstance(value, dict):
        return {key: _shifted(part, towards) for key, part in value.items()}
    if hasattr(value, "_fields"):
        return type(value)(*(_shifted(part, towards) for part in value))
    if isinstance(value, tuple):
        return tuple(_shifted(part, towards) for part in value)
    return value
