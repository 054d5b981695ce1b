"""Frequency response of a simulated loop by stepped sines: one sine a lane, all machines at once.

A sine is added to the command of an axis, or to its load, while the machine moves at a steady
speed. A *case* is one machine with one amplitude. Its lanes are all frequencies, and one lane
without a sine, which is subtracted: what the motion itself does is then no part of the response.
All sines have whole periods in one Hann window, so that they do not leak into each other.
"""

from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from hfc_design.controllers.controller import Controller, Stepped, View, begun
from hfc_design.core import devices
from hfc_design.core.numbers import Floats, Gains, Memory, Scalar, Xp
from hfc_design.motion.samples import Samples
from hfc_design.simulation.closed_loop import Loop, LoopState, next_state, start
from hfc_design.simulation.compiled import CHUNKS, spread
from hfc_design.simulation.flattening import Code, joined
from hfc_design.simulation.linearised import unlimited
from hfc_design.simulation.population import Machines, own_code_of
from hfc_design.simulation.stepping import nested

#: Length of the window [samples]; time before it in which the loop settles, as a share of it.
WINDOW, SETTLING = 3072, 0.5
#: Share of the settling time in which the machine reaches its speed.
STARTING = 0.3
#: Least number of periods in the window; highest frequency as a share of half the sampling rate.
PERIODS, HIGHEST = 3, 0.98


class Excited(NamedTuple):
    """A controller with ``(its gains, signals)`` as gains; the signals are added to its commands.

    If it is ``opened``, a signal replaces the command; axes without a signal (None) stay closed.
    The memory ends with the commands of the controller itself.
    """

    inner: Controller
    opened: bool

    @property
    def kind(self) -> str:
        """Name of the kind of the inner controller."""
        return self.inner.kind

    def initial_memory(self, zero: Scalar) -> Memory:
        """Return the memory of the inner controller; that of this one depends on the axes."""
        return self.inner.initial_memory(zero)

    def begun(self, xp: Xp, zero: Scalar, gains: Gains) -> Memory:
        """See ``controllers.controller.begun``."""
        return begun(self.inner, xp, zero, gains[0]), (zero,) * len(gains[1])

    def step(self, xp: Xp, gains: Gains, memory: Memory, view: View) -> Stepped:
        """Return the commands of the controller with the signals, and the new memory."""
        answers, inner = self.inner.step(xp, gains[0], memory[0], view)
        pairs = [*zip(answers, gains[1], strict=True)]
        if self.opened:
            return tuple(x if added is None else added for x, added in pairs), (inner, answers)
        return tuple(x if added is None else x + added for x, added in pairs), (inner, answers)


class Sines(NamedTuple):
    """Sines of a case (or of many: a leading axis), as amplitudes in the units of the drive."""

    command: Floats
    load: Floats | None  # None: no sines on the load
    shift: Floats  # (..., frequencies) of the reference


class Answers(NamedTuple):
    """Phasors (cases, frequencies) of a loop's signals under sines added to command, and load."""

    hertz: Floats  # (frequencies,)
    added: Any  # to the command
    command: Any  # of the drive, with what was added, within its limits
    answer: Any  # of the controller
    seen: Any  # the position that is fed back
    middle: Any  # real; the mean of this position, without that of the motion
    share: Any  # real; of the power of command and answer, that at the frequency of the sine
    load: Any  # added to the load
    moved: Any  # the position, under the sine of the load
    resisting: Any  # the command, under the sine of the load


class _Shared(NamedTuple):
    """Inputs that all cases share."""

    numbers: Any  # floats of the loop
    nominal: Any
    gains: Gains  # leaves (..., 1)
    row: Samples  # a column of a steady motion at the speeds
    moving: tuple[Floats, ...]  # travel, rate and acceleration, (steps, axes) each
    window: Floats  # (steps,)
    angles: Floats  # (frequencies,) per sample


class _Lane(NamedTuple):
    """Inputs of a lane."""

    angle: Any  # per sample
    command: Any  # amplitudes
    load: Any
    shift: Any  # of the reference


def stepped_sines(
    loop: Loop,
    machines: Machines,
    gains: Gains,
    row: Samples,
    speeds: tuple[float, ...],
    sines: Sines,
    axis: int,
    periods: Floats,
    window: int = WINDOW,
    opened: bool = False,
) -> Answers:
    """Return the answers of each machine to sines on the command and on the load of an axis.

    Args:
        loop: the loop, with limits, sensors and effects around its drives.
        machines: a machine for each case; ``standing`` if the loop has effects around its drives.
        gains: of one individual.
        row: a column of the samples of a steady motion.
        speeds: of each axis in this motion [unit of its position per s].
        sines: of each case.
        axis: number of the axis.
        periods: (frequencies,) whole numbers of periods in the window, see ``whole_periods``.
        window: number of samples in which the answers are measured.
        opened: whether the sine replaces the command of the axis, so that its loop is open; the
            controller then answers without limits.
    """
    settling, every = int(SETTLING * window), float(np.ravel(row.sample_time)[0])
    begun_at = np.clip(np.arange(settling + window + 1) / (STARTING * settling), 0.0, 1.0)
    rate = begun_at**2 * (3.0 - 2.0 * begun_at)
    travel, faster = np.cumsum(rate)[:-1] * every, np.diff(rate) / every
    moving = tuple(x[:, None] * np.array(speeds) for x in (travel, rate[:-1], faster))
    angles = 2.0 * np.pi * periods / window
    hann = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(window) / window)
    weights = np.concatenate([np.zeros(settling), hann])
    law = unlimited(loop.controller) if opened else loop.controller
    code, numbers = loop._replace(controller=Excited(law, opened)).apart
    shared = _Shared(numbers, machines.nominal, gains, row, moving, weights, angles)
    count = machines.size
    order = np.minimum(np.arange(count + -count % jax.device_count()), count - 1)
    cases = jax.tree.map(lambda leaf: leaf[order], (machines.actual, sines))
    with own_code_of(loop), np.errstate(all="ignore"):
        sums = np.asarray(_sums(code, axis, shared, cases))[:count]
    turns = angles[:, None] * np.arange(len(weights))
    unit = (np.cos(turns) * np.exp(-1j * turns)) @ weights
    parts = np.moveaxis(sums, -1, 0)
    on_command, on_load = parts[:, :, : len(angles)], parts[:, :, -len(angles) :]
    command, answer, seen, _ = on_command[:8:2] + 1j * on_command[1:8:2]
    resisting, _, _, moved = on_load[:8:2] + 1j * on_load[1:8:2]
    with np.errstate(all="ignore"):
        shares = 2.0 * np.abs([command, answer]) ** 2 / (on_command[8:10] * weights.sum())
    return Answers(
        angles / (2.0 * np.pi * every),
        sines.command[:, None] * unit,
        command,
        answer,
        seen,
        on_command[10] / weights.sum(),
        np.nan_to_num(shares).min(axis=0),
        0.0 * unit if sines.load is None else sines.load[:, None] * unit,
        moved,
        resisting,
    )


def whole_periods(count: int, window: int = WINDOW, least: float = PERIODS) -> Floats:
    """Return up to ``count`` whole numbers of periods in a window, evenly on a log scale."""
    return np.unique(np.geomspace(least, HIGHEST * window / 2.0, count).round())


@partial(jax.jit, static_argnums=(0, 1), compiler_options=devices.compiler_options())
def _sums(code: Code, axis: int, shared: _Shared, cases: Any) -> Any:
    """Return weighted sums (cases, lanes with a sine, 11) over the window, see ``_added``."""
    loop: Loop = joined(code, shared.numbers)
    gains = jax.tree.map(lambda row: row[0], jax.tree.map(nested, shared.gains))
    angles, zeros = shared.angles, jnp.zeros(len(shared.angles))

    def one_case(case: Any) -> Any:
        true, sines = case
        fixed, none = loop.coefficients(true), jnp.zeros(1)
        each: list[tuple[Any, ...]] = [(angles, sines.command + zeros, zeros, sines.shift)]
        if sines.load is not None:
            each.append((angles, zeros, sines.load + zeros, sines.shift))
        each.append((none, none, none, none))
        lanes = _Lane(*map(jnp.concatenate, zip(*each, strict=True)))
        law = gains, (None,) * len(loop.limits)
        first = start(loop, fixed, jnp.zeros(()), shared.row.start, law)
        first = jax.tree.map(lambda leaf: jnp.broadcast_to(leaf, lanes.angle.shape), first)
        about = (loop, axis, gains, shared.nominal, fixed)
        move = jax.vmap(partial(_moved, *about), in_axes=(0, 0, 0, None, None))

        def sample(carry: Any, given: Any) -> Any:
            before, (cos, sin), sums = carry
            *moving, weight = given
            row, every = row_at(shared.row, *moving), shared.row.sample_time
            after, signals = move(before, (cos, sin), lanes, row, every)
            sums = sums + _added(signals, cos, sin, weight)
            c, s = jnp.cos(lanes.angle), jnp.sin(lanes.angle)
            return (after, (cos * c - sin * s, sin * c + cos * s), sums), None

        turn = jnp.ones_like(lanes.angle), jnp.zeros_like(lanes.angle)
        begin = first, turn, jnp.zeros((len(lanes.angle) - 1, 11))
        return lax.scan(sample, begin, (*shared.moving, shared.window))[0][2]

    return spread(lambda some: lax.map(one_case, some), CHUNKS, (CHUNKS,))(cases)


def _moved(
    loop: Loop,
    axis: int,
    gains: Gains,
    nominal: Any,
    fixed: Any,
    before: LoopState,
    turn: tuple[Any, Any],
    lane: _Lane,
    row: Samples,
    every: Scalar,
) -> tuple[LoopState, tuple[Any, ...]]:
    """Return the state of a lane after a sample, and its signals: see ``Answers``."""
    cos, sin = turn
    drive, state, one = loop.machine.drives[axis], before.states[axis], row.axes[axis]
    parts = lane.angle * np.arange(len(one.loads)) / (len(one.loads) - 1.0)
    loads = [
        x + lane.load * (cos * jnp.cos(part) - sin * jnp.sin(part))
        for x, part in zip(one.loads, parts, strict=True)
    ]
    there = one._replace(loads=tuple(loads), reference=one.reference + lane.shift)
    axes = tuple(there if k == axis else x for k, x in enumerate(row.axes))
    added = tuple(lane.command * cos if k == axis else None for k in range(len(axes)))
    given = (nominal, fixed, every, (gains, added), before, row._replace(axes=axes))
    after = next_state(loop, *given)
    seen = getattr(drive.measured(fixed[axis], state), drive.seen[0])
    signals = after.commands[axis], after.memory[1][axis], seen, getattr(state, drive.position)
    return after, signals


def _added(signals: tuple[Any, ...], cos: Any, sin: Any, weight: Any) -> Any:
    """Return what a sample adds to the sums: four phasors, two powers, the mean position.

    The signals of the last lane, which has no sine, are subtracted.
    """
    off = [one[:-1] - one[-1] for one in signals]
    phasors = [part * x for x in off for part in (cos[:-1], -sin[:-1])]
    return weight * jnp.stack([*phasors, off[0] ** 2, off[1] ** 2, off[2]], axis=-1)


def row_at(row: Samples, travel: Any, rate: Any, acceleration: Any) -> Samples:
    """Return the row of a motion that has come so far, in scalars."""
    axes = []
    for k, one in enumerate(row.axes):
        faster = None if one.reference_acceleration is None else acceleration[k]
        now = one._replace(reference=one.reference + travel[k], reference_rate=rate[k])
        now = now._replace(loads=tuple(one.loads), noise=tuple(one.noise))
        axes.append(now._replace(target=now.reference, reference_acceleration=faster))
    return row._replace(axes=tuple(axes))
