"""The simulated loop, linearised in steady motions: the source of poles, margins and stiffness.

``closed_loop.next_state`` is one control sample; it is differentiated in two parts that are
connected by the signals. The machine, with its sensors, delays and other effects around the drives,
is the same for every controller: a search differentiates it once. The other part is the controller.
Steps of encoders and converters are left out, and no limit is reached: see ``Loop.smooth``.
An operating point is a steady motion at the speed of a reference, in which all moving quantities
are shifted by the same distance from sample to sample. The commands are those that the machine
needs, and the memory of the controller and its remaining errors are such that it gives these
commands. A *lane* is one machine in one steady motion, with one controller.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax.flatten_util import ravel_pytree

from hfc_design.controllers.controller import SLOW, RateLimited, Stepped, View, begun
from hfc_design.core import devices
from hfc_design.core.numbers import Floats, Gains, Mask, Memory, Scalar, Xp
from hfc_design.core.slopes import SLOPED, Sloped, parts
from hfc_design.motion.samples import Samples
from hfc_design.simulation.closed_loop import Loop, next_state, positions, start
from hfc_design.simulation.flattening import Code, joined
from hfc_design.stability.margins import OpenLoop
from hfc_design.stability.steady import (
    NEAR,
    SETTLED,
    TRIES,
    SteadyMotions,
    observable,
    solved,
)
from plants import Machine
from plants.around import commanded, fine


class Told(NamedTuple):
    """Stand-in for a controller: its gains are the commands, and it remembers what it sees."""

    kind: str = "told"

    def initial_memory(self, zero: Scalar) -> Memory:
        """Return no memory."""
        return ()

    def step(self, xp: Xp, gains: Gains, memory: Memory, view: View) -> Stepped:
        """Return the gains as commands, and the view as memory."""
        return gains, (view.axes, view.path)


@partial(jax.jit, static_argnums=0, compiler_options=devices.QUICKLY)
def _of_machine(
    code: Code, numbers: Any, nominal: Any, true: Any, every: Any, row: Any, x: Any
) -> Any:
    """Return per lane the values after a sample, derivatives by ``x``, and the signals as a tree.

    ``x`` has the states of the machine, commands, shifts of the references, and additional loads.
    The values are the states a sample later, the errors, all signals, and the positions before the
    sample.
    """
    loop: Loop = joined(code, numbers)

    def sample(true: Any, row: Samples, x: Any) -> Any:
        fixed, axes = loop.coefficients(true), len(row.axes)
        _, of = ravel_pytree(start(loop, fixed, jnp.zeros(()), row.start)._replace(commands=()))
        commands, shifts, loads = x[-3 * axes :].reshape(3, axes)
        there = []
        for one, shift, load in zip(row.axes, shifts, loads, strict=True):
            moved, pushed = one.reference + shift, tuple(one.loads + load)
            there.append(one._replace(reference=moved, loads=pushed, noise=tuple(one.noise)))
        before, row = of(x[: -3 * axes]), row._replace(axes=tuple(there))
        after = next_state(loop, nominal, fixed, every, tuple(commands), before, row)
        machine_state = after._replace(memory=(), commands=())
        errors = [signals["error"] for signals in after.memory[0]]
        parts = machine_state, errors, after.memory, positions(loop, before.states)
        whole = jnp.concatenate([ravel_pytree(part)[0] for part in parts])
        return whole, (whole, after.memory)

    def both(*about: Any) -> Any:
        slopes, (value, view) = jax.jacfwd(sample, argnums=2, has_aux=True)(*about)
        return value, slopes, view

    return jax.vmap(both)(true, row, x)


class Steady(NamedTuple):
    """Machines linearised in steady motions; the first axis of every leaf is that of the lanes.

    ``x(k+1) = a x + b u + e w`` for commands u and loads w; signals are ``s = c x`` and positions
    ``p = d x``.
    """

    a: Floats  # (states, states)
    b: Floats  # (states, axes)
    c: Floats  # (signals, states)
    d: Floats  # (axes, states)
    e: Floats  # (states, axes)
    off: Floats  # (signals, axes) change of the signals if the error of an axis grows by 1
    view: Any  # the signals as a tree
    signals: Floats  # (signals,)
    change: Floats  # (signals,) change of the signals from one sample to the next
    commands: Floats  # (axes,) that the motion needs
    exists: Mask  # whether the steady motion was found


def steady(loop: Loop, nominal: Any, true: Any, rows: Samples, speeds: Floats) -> Steady:
    """Return machines in steady motion along ``rows`` at ``speeds`` (lanes, axes), in float64."""
    smooth = _without_steps(loop._replace(controller=Told()))
    code, numbers = smooth.apart
    every, axes, still = float(np.ravel(rows.sample_time)[0]), speeds.shape[1], 0.0 * speeds

    def step(x: Floats) -> Any:
        whole = np.concatenate([x, still, still], axis=1)
        return _of_machine(code, numbers, nominal, true, np.float64(every), rows, whole)

    pushes = _pushes(loop, nominal) * speeds
    begun = partial(_begun, smooth, true, rows.start, speeds, pushes)
    with jax.enable_x64(True):
        x, one, exists = SteadyMotions(step, begun, every, speeds).found()
    size = x.shape[1] - axes
    _, references, loads = np.split(one.slopes[..., size:], 3, axis=2)
    signals = slice(size + axes, -axes)
    c = one.slopes[:, signals, :size]
    change = every * ((c @ one.along + references[:, signals]) @ speeds[..., None])[..., 0]
    change[np.abs(change) <= SETTLED * every * np.abs(speeds).max()] = 0.0
    some = observable(one.slopes[..., :size])
    return Steady(
        one.a[:, some][:, :, some],
        one.b[:, some],
        c[:, :, some],
        one.slopes[:, -axes:, :size][:, :, some],
        loads[:, :size][:, some],
        -c @ one.along,
        one.more,
        one.value[:, signals],
        change,
        x[:, size:],
        exists,
    )


def _pushes(loop: Loop, nominal: Any) -> Floats:
    """Return the approximate command over speed of each axis; 0 without a known top speed."""
    pushes = np.zeros(len(loop.limits))
    for k, (drive, parameters) in enumerate(zip(loop.machine.drives, nominal, strict=True)):
        top = drive.top_speed(parameters)
        _, most = drive.largest_commands(parameters, loop.limits[k])
        if np.isfinite([most, top]).all() and top > 0.0:
            pushes[k] = most / top
    return pushes


def _begun(
    loop: Loop, true: Any, starts: Any, speeds: Floats, commands: Floats, factor: float
) -> Floats:
    """Return initial states and commands, (lanes, states + axes), for speeds times ``factor``.

    The ``commands`` are roughly those that the speeds need; they are 0 if ``factor`` is not 1.
    """
    states, commands = [], commands * (factor == 1.0)
    for drive, state, speed in zip(loop.machine.drives, starts, factor * speeds.T, strict=True):
        rates = {drive.velocity, drive.seen[1], *drive.encoders.values()}
        states.append(state._replace(**dict.fromkeys(rates, speed)))
    whole = start(loop, loop.coefficients(true), 0.0, tuple(states))._replace(commands=())
    # With other commands an amplifier at its limit would have no slope: see plants.five_axis.
    moving = tuple(map(commanded, whole.states, commands.T))
    leaves = *jax.tree.leaves(whole._replace(states=moving)), *commands.T
    return np.stack([np.broadcast_to(np.asarray(x, float), len(speeds)) for x in leaves], axis=1)


def _without_steps(loop: Loop) -> Loop:
    """Return ``Loop.smooth`` without limits, and without steps and limits inside the drives."""
    smooth = loop.smooth
    limits = (None,) * len(loop.limits)
    return smooth._replace(machine=_fine(smooth.machine), limits=limits)


@cache  # always the same object for a machine: it is a key of compiled code
def _fine(machine: Machine) -> Machine:
    return replace(machine, drives=tuple(map(fine, machine.drives)))


def unlimited(controller: Any) -> Any:
    """Return the controller without limits on the size and rate of its commands."""
    if isinstance(controller, RateLimited):
        return unlimited(controller.inner)
    if isinstance(controller, tuple) and not hasattr(controller, "_fields"):
        return tuple(map(unlimited, controller))
    if not hasattr(controller, "step"):
        return controller
    fields = {key: unlimited(getattr(controller, key)) for key in controller._fields}
    none = {"limit": None, "limits": (None,) * len(fields.get("limits", ()))}
    return controller._replace(**fields | {key: x for key, x in none.items() if key in fields})


class Controllers(NamedTuple):
    """Controllers linearised about steady motions; the first axis of every leaf is that of lanes.

    ``m(k+1) = a m + b s`` for a memory m and signals s; the commands are ``c m + d s``.
    """

    a: Floats  # (memory, memory)
    b: Floats  # (memory, signals)
    c: Floats  # (axes, memory)
    d: Floats  # (axes, signals)
    errors: Floats  # (axes,) that remain in the steady motion
    exists: Mask  # whether a state was found in which they give the needed commands


def controlled(
    loop: Loop, nominal: Any, gains: Gains, near: Steady, off: Floats | None = None
) -> Controllers:
    """Return controllers with ``gains``, linearised in the steady motion of each lane of ``near``.

    If ``off`` (lanes,) is given, it is added to the errors at which they are linearised.
    """
    law = unlimited(loop.controller)
    lanes, axes = near.commands.shape
    rows = jax.tree.map(_rows, gains)
    begins = begun(law, SLOPED, 0.0, rows)
    living = _living(begins)
    first, size = np.array([*living.values()], float), len(living)
    memory = slice(size)
    signals_of, seen = jax.tree.flatten(near.view)
    count = size + len(signals_of)

    def at(x: Floats) -> tuple[Floats, Floats, Floats]:
        """Return residuals for memories and errors ``x``, derivatives of these, and all slopes."""
        signals = near.signals + (near.off @ x[:, size:, None])[..., 0]
        whole = np.concatenate([x[:, memory], signals], axis=1).T
        given = [
            Sloped(variable, unit[:, None])
            for variable, unit in zip(whole, np.eye(count), strict=True)
        ]
        numbers = dict(zip(living, given, strict=False))
        before = jax.tree_util.tree_map_with_path(numbers.get, begins)
        told_of, path = jax.tree.unflatten(seen, given[size:])
        view = View(told_of, path, nominal)
        commands, after = law.step(SLOPED, rows, before, view)
        later = _living(after)
        both = [parts(one, count, lanes) for one in (*(later[path] for path in living), *commands)]
        value = np.stack([output for output, _ in both], axis=1)
        slopes = np.stack([derivative for _, derivative in both]).transpose(2, 0, 1)
        matrix = np.concatenate([slopes[..., memory], slopes[..., size:] @ near.off], axis=2)
        matrix[:, memory, memory] -= np.eye(size)
        drift = (slopes[:, memory, size:] @ near.change[..., None])[..., 0]
        left = value - np.concatenate([x[:, memory], near.commands], axis=1)
        if drift.any():
            left[:, memory] += solved(matrix[:, memory, memory], drift)
        return left, matrix, slopes

    near_by = np.concatenate([np.tile(first, (lanes, 1)), np.zeros((lanes, axes))], axis=1)
    with np.errstate(all="ignore"):
        x, left, slopes = _by_newton(at, near_by, SETTLED * np.abs(near.commands).max())
        if off is not None:
            slopes = at(np.hstack([x[:, memory], x[:, size:] + off[:, None]]))[2]
    scale = np.abs(near.commands).max(axis=1)
    come = np.abs(left[:, size:]).max(axis=1) <= NEAR * np.maximum(scale, np.abs(x).max(axis=1))
    of_both = [slopes[:, memory], slopes[:, size:]]
    a, b, c, d = (part[..., where] for part in of_both for where in (memory, slice(size, None)))
    return Controllers(a, b, c, d, x[:, size:], come & np.isfinite(slopes).all(axis=(1, 2)))


def _by_newton(
    at: Callable[[Floats], tuple[Floats, Floats, Floats]], x: Floats, wanted: float
) -> tuple[Floats, Floats, Floats]:
    """Return solutions, residuals (``wanted`` at most, if it converges) and slopes, from ``x``."""
    left, matrix, slopes = at(x)
    size_of = np.maximum(np.abs(matrix).max(axis=2), np.finfo(float).tiny)
    share = np.ones(len(x))
    for _ in range(TRIES):
        if (np.abs(left) <= wanted).all():
            break
        move = solved(np.nan_to_num(matrix), -np.nan_to_num(left))
        there = x + share[:, None] * move
        trial = at(there)
        new, old = (np.linalg.norm(each / size_of, axis=1) for each in (trial[0], left))
        better = np.nan_to_num(new, nan=np.inf) < np.nan_to_num(old, nan=np.inf)
        share = np.where(better, np.minimum(2.0 * share, 1.0), 0.25 * share)
        for old, new in zip((x, left, matrix, slopes), (there, *trial), strict=True):
            old[better] = new[better]
        if (share < NEAR).all():
            break
    return x, left, slopes


def _living(memory: Memory) -> dict[Any, Any]:
    """Return the numbers of a memory that are not learned, by their paths in it."""
    return {
        path: number
        for path, number in jax.tree_util.tree_flatten_with_path(memory)[0]
        if not any(getattr(key, "name", None) in SLOW for key in path)
    }


def _rows(leaf: Any) -> Any:
    """Return a leaf (..., lanes) as nested tuples of its rows (lanes,)."""
    return leaf if np.ndim(leaf) == 1 else tuple(map(_rows, leaf))


def loops(near: Steady, controllers: Controllers, lane: int) -> list[tuple[OpenLoop, OpenLoop]]:
    """Return two loops for each axis of a lane: one opened at the command of the axis, one closed.

    In the first, the other axes are closed. The second leads from load to position of the axis.
    """
    size, more = near.a.shape[-1], controllers.a.shape[-1]
    c = np.hstack([controllers.d[lane] @ near.c[lane], controllers.c[lane]])
    upper = [near.a[lane], np.zeros((size, more))]
    a = np.block([upper, [controllers.b[lane] @ near.c[lane], controllers.a[lane]]])
    each = near.b[lane], near.e[lane], near.d[lane].T
    b, loads, places = (np.pad(x, ((0, more), (0, 0))) for x in each)
    pairs = []
    for k in range(b.shape[1]):
        others = np.arange(b.shape[1]) != k
        opened = OpenLoop(a + b[:, others] @ c[others], b[:, k], c[k])
        pairs.append((opened, OpenLoop(a + b @ c, loads[:, k], places[:, k])))
    return pairs
