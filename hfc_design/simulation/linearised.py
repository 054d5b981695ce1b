"""The simulated loop, linearised where it moves steadily: poles, margins and stiffness come of it.

``closed_loop.moved`` is one control sample; it is differentiated in two parts that meet at the
signals. The machine with its sensors, delays and whatever else stands around a drive is the same
for every controller, so that a search needs it once; a controller is small, and every law has a
slope. Steps of encoders and converters are left out and no limit is met: see ``Loop.smooth``. An
operating point is a steady motion at the speed of a reference, where all that moves is shifted by
the same way from sample to sample. There the commands are what the machine needs, and what the
controller remembers, and the errors that it leaves, are such that it gives them.
"""

from dataclasses import replace
from functools import cache, partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax.flatten_util import ravel_pytree

from hfc_design.controllers.controller import LEARNT, RateLimited, Stepped, View
from hfc_design.core.numbers import Floats, Gains, Integers, Mask, Memory, Scalar, Xp
from hfc_design.core.slopes import SLOPED, Sloped, parts
from hfc_design.motion.samples import Samples
from hfc_design.simulation.closed_loop import Loop, moved, positions, start
from hfc_design.simulation.packing import Code, joined
from hfc_design.stability.margins import OpenLoop
from plants import Machine
from plants.around import fine

#: Newton's steps at most, and the change [1] at which it has come, or has come near enough.
TRIES, SETTLED, NEAR = 30, 1e-9, 1e-5
#: A matrix of even numbers with a smaller determinant may be singular.
SINGULAR = 1e-7
#: What differs by a smaller share is the same but for its last bits.
ROUNDED = 1e-13
#: How many times as fast a motion is looked for first where none is found.
FAST = 1e3


class Told(NamedTuple):
    """Stands for a controller: gives the commands that are its gains, remembers what it sees."""

    kind: str = "told"

    def initial_memory(self, zero: Scalar) -> Memory:
        """Nothing."""
        return ()

    def step(self, xp: Xp, gains: Gains, memory: Memory, view: View) -> Stepped:
        """The commands, and the view."""
        return gains, (view.axes, view.path)


#: It runs a moment, and is compiled in a fifth of the time.
QUICKLY = {"xla_backend_optimization_level": 0, "xla_llvm_disable_expensive_passes": True}


@partial(jax.jit, static_argnums=0, compiler_options=QUICKLY)
def _of_machine(code: Code, numbers: Any, told: Any, true: Any, every: Any, row: Any, x: Any) -> Any:
    """Of every lane what a sample makes of ``x``, derivatives of that, and the signals as a tree.

    ``x`` are the numbers of the machine, commands, shifts of the references, and loads beside what
    is there; it becomes the numbers a sample later, signals and positions.
    """
    loop: Loop = joined(code, numbers)

    def sample(true: Any, row: Samples, x: Any) -> Any:
        _, of = ravel_pytree(start(loop, jnp.zeros(()), row.start)._replace(commands=()))
        fixed, axes = loop.coefficients(true), len(row.axes)
        commands, shifts, loads = x[-3 * axes :].reshape(3, axes)
        there = tuple(
            one._replace(
                reference=one.reference + shift,
                loads=tuple(one.loads + load),
                noise=tuple(one.noise),
            )
            for one, shift, load in zip(row.axes, shifts, loads, strict=True)
        )
        before = of(x[: -3 * axes])
        after = moved(loop, told, fixed, every, tuple(commands), before, row._replace(axes=there))
        own = after._replace(memory=(), commands=())
        parts = own, after.memory, positions(loop, before.states)
        whole = jnp.concatenate([ravel_pytree(part)[0] for part in parts])
        return whole, (whole, after.memory)

    def both(*about: Any) -> Any:
        slopes, (value, view) = jax.jacfwd(sample, argnums=2, has_aux=True)(*about)
        return value, slopes, view

    return jax.vmap(both)(true, row, x)


class Steady(NamedTuple):
    """Machines in steady motions, linearised; every leaf begins with the lanes.

    ``x(k+1) = a x + b u + e w`` for commands u and loads w; of signals ``s = c x``, of positions
    ``p = d x``.
    """

    a: Floats  # (states, states)
    b: Floats  # (states, axes)
    c: Floats  # (signals, states)
    d: Floats  # (axes, states)
    e: Floats  # (states, axes)
    off: Floats  # (signals, axes) what an error of one changes of what is seen
    view: Any  # the signals as a tree
    signals: Floats  # (signals,)
    change: Floats  # (signals,) of them, from a sample to the next
    commands: Floats  # (axes,)
    found: Mask  # whether there is such a motion


def steady(loop: Loop, told: Any, true: Any, rows: Samples, speeds: Floats) -> Steady:
    """Machines that follow the ``rows`` with ``speeds`` (lanes, axes), a lane each; float64."""
    loop = _without_steps(loop._replace(controller=Told()))
    code, numbers = loop.apart
    lanes, axes = speeds.shape
    every = float(np.ravel(rows.sample_time)[0])
    rows_of = [_lane(rows, k) for k in range(lanes)]

    def begun(factor: float) -> Floats:
        return np.array([_begun(loop, *own) for own in zip(rows_of, factor * speeds, strict=True)])

    def found(x: Floats, speeds: Floats) -> tuple[Floats, Mask, tuple[Floats, ...]]:
        """Newton's method: state and commands, whether they are found, and what is near them."""
        for _ in range(TRIES):
            value, slopes, view = _of_machine(code, numbers, told, true, every, rows, x)
            value, slopes = np.array(value), np.array(slopes)
            errors = _errors(view)
            a, b = slopes[:, :size, of_state], slopes[:, :size, of_command]
            c = slopes[:, size:-axes, of_state]
            along = _along(a, c[:, errors])
            # What depends on the place, as cogging does, is 0 in the mean over the way.
            off = a @ along - along
            off[np.abs(off) <= ROUNDED * (np.abs(a) @ np.abs(along))] = 0.0
            a = a + np.where(moving, off @ c[:, errors], 0.0)
            way = (along @ (every * speeds)[..., None])[..., 0]
            off = value[:, :size] - x[:, of_state] - way
            off = np.concatenate([off, value[:, size:][:, errors]], axis=1)
            matrix = np.block([[a - unit, b], [c[:, errors], np.zeros((lanes, axes, axes))]])
            heard = _heard(slopes[:, :, of_state])
            some = np.append(heard, np.ones(axes, bool))
            move = np.zeros_like(off)
            whole = np.nan_to_num(matrix)[:, some][:, :, some]
            move[:, some] = solved(whole, -np.nan_to_num(off)[:, some])
            x[:, : size + axes] += move
            scale = np.maximum(np.abs(x).max(axis=1), np.finfo(float).tiny)
            far = np.abs(move).max(axis=1) / scale
            if (far <= SETTLED).all():
                break
        sound = np.isfinite(slopes).all(axis=(1, 2)) & np.isfinite(off).all(axis=1)
        return x, (far <= NEAR) & sound, (a, c, along, value, slopes, view)

    first = begun(1.0)
    size, unit = first.shape[1], np.eye(first.shape[1])
    none, moving = np.zeros((lanes, 3 * axes)), speeds.any(axis=1)[:, None, None]
    of_state, of_command = slice(size), slice(size, size + axes)
    x, come, about = found(np.concatenate([first, none], axis=1), speeds)
    if not come.all():  # nothing touches behind a gap; much faster, what brakes does
        fast, _, _ = found(np.concatenate([begun(FAST), none], axis=1), FAST * speeds)
        fast[:, of_state] += first - begun(FAST)
        again, came, others = found(np.where(np.isfinite(fast), fast, 0.0), speeds)
        mended = came & ~come
        pick = [(mended, old, new) for old, new in zip(about[:5], others[:5], strict=True)]
        about = (*(np.where(m.reshape(-1, *[1] * (old.ndim - 1)), new, old) for m, old, new in pick), about[5])
        x, come = np.where(mended[:, None], again, x), come | came
    a, c, along, value, slopes, view = about
    references = slopes[:, size:-axes, size + axes : size + 2 * axes]
    change = ((c @ along + references) @ (every * speeds)[..., None])[..., 0]
    change[np.abs(change) <= SETTLED * every * np.abs(speeds).max()] = 0.0
    kept = _heard(slopes[:, :, of_state])
    return Steady(
        a[:, kept][:, :, kept],
        slopes[:, :size, of_command][:, kept],
        c[:, :, kept],
        slopes[:, -axes:, of_state][:, :, kept],
        slopes[:, :size, -axes:][:, kept],
        -c @ along,
        view,
        value[:, size:-axes],
        change,
        x[:, of_command],
        come,
    )


def _heard(slopes: Floats) -> Mask:
    """(states,) which of them change a signal or a position now or later.

    Others may run by themselves, as a count of samples does, and are no part of any loop.
    """
    size, hears = slopes.shape[2], (slopes != 0.0).any(axis=0)
    found = hears[size:].any(axis=0)
    for _ in range(size):
        found = found | hears[:size][found].any(axis=0)
    return np.asarray(found)


def _without_steps(loop: Loop) -> Loop:
    """``Loop.smooth``, and what the drives themselves count and convert is as fine."""
    smooth = loop.smooth
    limits = (None,) * len(loop.limits)
    return smooth._replace(machine=_fine(smooth.machine), limits=limits)


@cache  # the same machine for the same one: it is a key of compiled code
def _fine(machine: Machine) -> Machine:
    return replace(machine, drives=tuple(map(fine, machine.drives)))


def _unlimited(controller: Any) -> Any:
    """The same controller whose commands may have any size and rate."""
    if isinstance(controller, RateLimited):
        return _unlimited(controller.inner)
    if isinstance(controller, tuple) and not hasattr(controller, "_fields"):
        return tuple(map(_unlimited, controller))
    if not hasattr(controller, "step"):
        return controller
    own = {key: _unlimited(getattr(controller, key)) for key in controller._fields}
    own |= {"limit": None} if "limit" in own else {}
    return controller._replace(**own | ({"limits": (None,) * len(own["limits"])} if "limits" in own else {}))


def _begun(loop: Loop, row: Samples, speeds: Floats) -> Floats:
    """The numbers of a machine with nothing remembered, all of whose parts have its speeds."""
    states = []
    for drive, state, speed in zip(loop.machine.drives, row.start, speeds, strict=True):
        rates = {drive.velocity, drive.seen[1], *drive.encoders.values()}
        states.append(state._replace(**dict.fromkeys(rates, float(speed))))
    whole = start(loop, 0.0, tuple(states))._replace(commands=())
    return np.array(ravel_pytree(whole)[0], np.float64)


def _lane(tree: Any, k: int) -> Any:
    return jax.tree.map(lambda leaf: leaf[k], tree)


def _errors(view: Any) -> Integers:
    """Places of the errors of all axes among the signals."""
    axes, path = jax.tree.map(lambda leaf: 0.0, view)
    marked = tuple(own | {"error": float(k)} for k, own in enumerate(axes, 1))
    flat = np.array(ravel_pytree((marked, path))[0])
    return np.array([int(np.flatnonzero(flat == k)[0]) for k in range(1, len(axes) + 1)])


def _along(a: Floats, errors: Floats) -> Floats:
    """(lanes, states, axes) what moves with a unit of way of each axis, and changes least else."""
    lanes, size, axes = *a.shape[:2], errors.shape[1]
    ways = np.concatenate([np.zeros((size, axes)), -np.eye(axes)])
    whole = np.concatenate([a - np.eye(size), errors], axis=1)
    found = [solved(whole, np.tile(way, (lanes, 1))) for way in ways.T]
    return np.stack(found, axis=2)


def solved(matrix: Floats, right: Floats) -> Floats:
    """(lanes, n) the least solutions of equations, in units that make them even."""
    rows, columns = np.ones(matrix.shape[:2]), np.ones(matrix.shape[::2])
    for _ in range(3):
        for units, axis in ((rows, 2), (columns, 1)):
            largest = np.abs(rows[:, :, None] * matrix * columns[:, None]).max(axis=axis)
            units /= np.sqrt(np.where(largest > 0.0, largest, 1.0))
    even, told = rows[:, :, None] * matrix * columns[:, None], rows * right
    found, open_ = np.zeros(columns.shape), told.any(axis=1)
    if matrix.shape[1] == matrix.shape[2]:
        regular = open_ & (np.abs(np.linalg.det(even)) > SINGULAR)
        found[regular] = np.linalg.solve(even[regular], told[regular, :, None])[..., 0]
        open_ &= ~regular
    for k in np.flatnonzero(open_):
        found[k] = np.linalg.lstsq(even[k], told[k], rcond=1e-11)[0]
    found[np.abs(found) <= ROUNDED * np.abs(found).max(axis=1, initial=0.0)[:, None]] = 0.0
    return np.asarray(columns * found)


class Controllers(NamedTuple):
    """Controllers near steady motions; every leaf begins with the lanes.

    ``m(k+1) = a m + b s``, and the commands are ``c m + d s``.
    """

    a: Floats  # (memory, memory)
    b: Floats  # (memory, signals)
    c: Floats  # (axes, memory)
    d: Floats  # (axes, signals)
    errors: Floats  # (axes,) that are left
    found: Mask  # whether they can give the commands that are needed


def controlled(loop: Loop, told: Any, gains: Gains, near: Steady) -> Controllers:
    """Controllers whose ``gains`` have the lanes of ``near`` behind; float64."""
    law = _unlimited(loop.controller)
    lanes, axes = near.commands.shape
    begins = law.initial_memory(0.0)
    living = _living(begins)
    first, size = np.array([*living.values()], float), len(living)
    memory, rows = slice(size), jax.tree.map(_rows, gains)
    signals_of, seen = jax.tree.flatten(_lane(near.view, 0))
    count = size + len(signals_of)

    def at(x: Floats) -> tuple[Floats, Floats, Floats]:
        """What is left to solve for memories and errors ``x``, its derivatives, all slopes."""
        signals = near.signals + (near.off @ x[:, size:, None])[..., 0]
        whole = np.concatenate([x[:, memory], signals], axis=1).T
        given = [Sloped(own, unit[:, None]) for own, unit in zip(whole, np.eye(count), strict=True)]
        numbers = dict(zip(living, given, strict=False))
        before = jax.tree_util.tree_map_with_path(lambda path, own: numbers.get(path, own), begins)
        view = View(*jax.tree.unflatten(seen, given[size:]), told)
        commands, after = law.step(SLOPED, rows, before, view)
        later = _living(after)
        both = [parts(one, count, lanes) for one in (*(later[path] for path in living), *commands)]
        value = np.stack([own for own, _ in both], axis=1)
        slopes = np.stack([own for _, own in both]).transpose(2, 0, 1)
        matrix = np.concatenate([slopes[..., memory], slopes[..., size:] @ near.off], axis=2)
        matrix[:, memory, memory] -= np.eye(size)
        drift = (slopes[:, memory, size:] @ near.change[..., None])[..., 0]
        left = value - np.concatenate([x[:, memory], near.commands], axis=1)
        if drift.any():
            left[:, memory] += solved(matrix[:, memory, memory], drift)
        return left, matrix, slopes

    x = np.concatenate([np.tile(first, (lanes, 1)), np.zeros((lanes, axes))], axis=1)
    left, matrix, slopes = at(x)
    size_of = np.maximum(np.abs(matrix).max(axis=2), np.finfo(float).tiny)
    share, wanted = np.ones(lanes), SETTLED * np.abs(near.commands).max()
    with np.errstate(all="ignore"):
        for _ in range(TRIES):
            if (np.abs(left) <= wanted).all():
                break
            move = solved(np.nan_to_num(matrix), -np.nan_to_num(left))
            there = x + share[:, None] * move
            found = at(there)
            better = _size(found[0] / size_of) < _size(left / size_of)
            share = np.where(better, np.minimum(2.0 * share, 1.0), 0.25 * share)
            for old, new in zip((x, left, matrix, slopes), (there, *found), strict=True):
                old[better] = new[better]
            if (share < NEAR).all():
                break
        scale = np.abs(near.commands).max(axis=1)
    come = np.abs(left[:, size:]).max(axis=1) <= NEAR * np.maximum(scale, np.abs(x).max(axis=1))
    of_both = [slopes[:, memory], slopes[:, size:]]
    a, b, c, d = (part[..., where] for part in of_both for where in (memory, slice(size, None)))
    return Controllers(a, b, c, d, x[:, size:], come & np.isfinite(slopes).all(axis=(1, 2)))


def _living(memory: Memory) -> dict[Any, Any]:
    """The numbers of a memory that are not learnt, by where they are."""
    return {
        path: number
        for path, number in jax.tree_util.tree_flatten_with_path(memory)[0]
        if not any(getattr(key, "name", None) in LEARNT for key in path)
    }


def _rows(leaf: Any) -> Any:
    """A leaf (..., lanes) as nested tuples of its (lanes,) rows."""
    return leaf if np.ndim(leaf) == 1 else tuple(map(_rows, leaf))


def _size(left: Floats) -> Floats:
    size = np.linalg.norm(left, axis=1)
    return np.where(np.isfinite(size), size, np.inf)


def opened(near: Steady, own: Controllers, lane: int) -> list[OpenLoop]:
    """The loop of a lane, opened at the command of each axis while the others are closed."""
    a, b, c = _together(near, own, lane)
    found = []
    for k in range(b.shape[1]):
        others = np.arange(b.shape[1]) != k
        found.append(OpenLoop(a + b[:, others] @ c[others], b[:, k], c[k]))
    return found


def pushed(near: Steady, own: Controllers, lane: int) -> list[OpenLoop]:
    """The closed loop of a lane from the load of each axis to its position."""
    a, b, c = _together(near, own, lane)
    more = [(0, len(a) - len(near.a[lane]))]
    loads, places = np.pad(near.e[lane], (*more, (0, 0))), np.pad(near.d[lane], ((0, 0), *more))
    return [OpenLoop(a + b @ c, *each) for each in zip(loads.T, places, strict=True)]


def _together(near: Steady, own: Controllers, lane: int) -> tuple[Floats, Floats, Floats]:
    """Machine and controller of a lane with all commands open: states, commands, answers."""
    a, b, c = near.a[lane], near.b[lane], near.c[lane]
    size, more = len(a), own.a.shape[-1]
    whole = np.block([[a, np.zeros((size, more))], [own.b[lane] @ c, own.a[lane]]])
    return whole, np.pad(b, ((0, more), (0, 0))), np.hstack([own.d[lane] @ c, own.c[lane]])
