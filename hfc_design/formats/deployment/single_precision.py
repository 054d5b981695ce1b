"""Commands of a controller in float32, to measure how much single precision changes them.

C code in float adds in another order, so its commands are not equal to these, but deviate by about
as much from those in double. This deviation determines the tolerance of the test vectors, and in
which samples code in float is compared.

Rounding may change a decision of a controller (which rule is corrected, whether an integral stops).
Then its later commands differ, and both are right. Therefore commands after a close decision are
not compared until the controller's memory is reset.
"""

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from random import Random
from typing import Any, NamedTuple

import jax
import numpy as np

from hfc_design.controllers.controller import (
    AxisLaw,
    Controller,
    PerAxis,
    View,
    begun,
    primed,
    rate_limited,
)
from hfc_design.core.numbers import ARRAYS, Floats, Gains, Plain
from hfc_design.files.design import Design
from hfc_design.formats.deployment.test_inputs import RESETS

#: ``Xp`` functions for float32; exp and tanh are computed in double and then rounded.
SINGLE = ARRAYS._replace(
    bell=lambda rate, distance: _rounded(np.exp, (-rate * distance) * distance),
    tanh=lambda x: _rounded(np.tanh, x),
)


def _rounded(function: np.ufunc, x: Floats) -> np.ndarray:
    return np.asarray(function(np.asarray(x, np.float64)), np.float32)


def single(value: Plain) -> Plain:
    """Return tables and records with all real numbers rounded to single precision."""

    def rounded(leaf: Any) -> Any:
        if isinstance(leaf, float):
            return np.float32(leaf)
        real = isinstance(leaf, np.ndarray) and leaf.dtype.kind == "f"
        return leaf.astype(np.float32) if real else leaf

    return jax.tree.map(rounded, value)


def commands(
    design: Design,
    axes: tuple[str, ...],
    rows: np.ndarray,
    view_of: Callable[[np.ndarray], View],
    law: AxisLaw | None,
) -> Floats:
    """Return the commands (tries, samples, axes) of a design for ``rows`` (samples, inputs, tries).

    ``view_of`` converts a sample (inputs, n) to a view; for ``law`` see ``runtime.Controller``. As
    in C, the memory stays as it was where a command is not finite.
    """
    begins = np.array(sorted(RESETS))
    lengths = np.diff(begins, append=len(rows))
    # A part after a reset does not depend on samples before it: all parts run at the same time.
    steps = begins + np.minimum(np.arange(lengths.max())[:, None], lengths - 1)  # (longest, parts)
    lanes = rows[steps].swapaxes(1, 2).reshape(len(steps), rows.shape[1], -1)
    views = map(view_of, lanes.astype(np.float32))
    controller, gains = _controller(design, axes, law), single(design.controller.law_gains())
    stepped = _stepped(controller, gains, views, lanes.shape[-1])
    parts = stepped.reshape(len(steps), len(begins), rows.shape[2], -1)
    each = [parts[:length, k] for k, length in enumerate(lengths)]
    return np.concatenate(each).swapaxes(0, 1)


def _controller(design: Design, axes: tuple[str, ...], law: AxisLaw | None) -> Controller:
    if law is None:
        return design.commanding(axes)
    per_axis = PerAxis(design.kind.name, (law,))
    return rate_limited(per_axis, design.limits.commands(axes), design.changes(axes))


def _stepped(controller: Controller, gains: Gains, views: Iterable[View], lanes: int) -> Floats:
    """Return the commands (steps, lanes, axes) for ``views``; a lane is a try after one reset."""
    zero, stored = np.zeros(lanes, np.float32), []
    memory = begun(controller, SINGLE, zero, gains)
    with np.errstate(all="ignore"):
        for k, view in enumerate(views):
            before = memory if k else primed(controller, SINGLE, gains, memory, view)
            commanded, after = controller.step(SINGLE, gains, before, view)
            stored.append(np.stack([zero + command for command in commanded], axis=1))
            finite = np.isfinite(stored[-1]).all(axis=1)
            chosen = partial(np.where, finite)  # new memory in lanes with finite commands
            memory = after if finite.all() else jax.tree.map(chosen, after, memory)
    return np.stack(stored, dtype=np.float64)


#: Tolerance of a command in double precision, as a share of the largest command.
DOUBLE = 1e-12
#: Factor from the deviation of the law in float32 to the tolerance: C adds in another order.
MARGIN = 4.0
#: Smallest deviation that is assumed for float32, as a share of the largest command.
ROUNDING = 2.0**-21
#: Largest disturbance of inputs, in roundings of float32, that is to reveal close decisions.
NOISE = 16.0
#: Growth of the deviation that shows that a decision has changed. If none has, inputs that are off
#: by ``NOISE`` roundings make the deviation at most 4 x ``NOISE`` times as large.
JUMP = 16.0
#: Number of random disturbances; each is tried with both signs, to get both decisions.
TRIES = 2


class Tolerance(NamedTuple):
    """Tolerance of a command, in the command's unit."""

    double: float  # of code in double
    single: float  # of code in float
    alike: tuple[bool, ...]  # (samples,) whether single precision decides as double does


def rounded(inputs: Floats) -> Iterator[Floats]:
    """Yield the inputs rounded to float32; then twice the same, off by up to one more rounding."""
    yield inputs.astype(np.float32).astype(float)
    yield from _disturbed(inputs, 1.0, 1)


def disturbed(inputs: Floats) -> Iterator[Floats]:
    """Yield the inputs in single precision, off by up to ``NOISE`` roundings, reproducibly."""
    yield from _disturbed(inputs, NOISE, TRIES)


def _disturbed(inputs: Floats, noise: float, tries: int) -> Iterator[Floats]:
    for seed in range(tries):
        random = Random(seed)
        off = np.array([[random.uniform(-noise, noise) for _ in row] for row in inputs])
        for side in (1.0, -1.0):
            yield (inputs * (1.0 + side * 2.0**-23 * off)).astype(np.float32).astype(float)


def tolerance(commands: Floats, near: Floats, far: Floats) -> Tolerance:
    """Return the tolerance of ``commands`` (samples, axes), given in double, from those in float32.

    ``near`` and ``far`` (tries, samples, axes) are those for ``rounded`` and ``disturbed`` inputs.
    """
    largest = float(np.abs(commands).max())
    off, further = (np.abs(each - commands).max(axis=(0, 2)) for each in (near, far))
    alike = np.ones(len(commands), dtype=bool)
    usual = max(ROUNDING * largest, 2.0 * float(np.median(off)))
    begins = sorted(RESETS)
    for begin, end in zip(begins, [*begins[1:], len(commands)], strict=True):
        level, first = usual, end  # deviation so far; sample in which a decision may have changed
        for k in range(begin, end):
            if further[k] > MARGIN * max(level, off[k]):
                first = min(first, k)
            if not (off[k] <= JUMP * level and further[k] <= 4.0 * NOISE * max(level, off[k])):
                alike[min(first, k) : end] = False
                break
            level = max(level, off[k])
    worst = float(off[alike].max(initial=ROUNDING * largest / MARGIN))
    return Tolerance(DOUBLE * largest, MARGIN * worst, tuple(map(bool, alike)))
