"""Frequency response of a design's loop as simulated, by stepped sines, all machines at once.

A sine is added to the command of an axis, or to its load, while the machine moves at a steady
speed. A *case* is one machine with one amplitude. Its lanes are all frequencies, and some without a
sine, one of which is subtracted: what the motion itself does is then no part of the response. All
sines have whole periods in one Hann window, so that they do not leak into each other.
"""

from collections.abc import Sequence
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from hfc_design.controllers.controller import Controller, Stepped, View, begun
from hfc_design.core import devices
from hfc_design.core.numbers import Floats, Gains, Integers, Memory, Scalar, Xp
from hfc_design.core.records import UserError, option
from hfc_design.core.wording import three_digits
from hfc_design.files.design import AnyDesign
from hfc_design.files.loop_setup import (
    controller_of,
    load_design,
    own_scenario,
    with_converter,
)
from hfc_design.files.named_scenario import AnyScenario, load_scenario
from hfc_design.files.scenario import Scenario
from hfc_design.motion.samples import Samples
from hfc_design.simulation.closed_loop import Loop, LoopState, closed_loop, next_state, start
from hfc_design.simulation.compiled import CHUNKS, LANES, spread
from hfc_design.simulation.flattening import Code, joined
from hfc_design.simulation.linearised import unlimited
from hfc_design.simulation.loop_margins import Point, near, operating_points, steady_row
from hfc_design.simulation.population import Machines, own_code_of, standing
from hfc_design.simulation.sensors import largest_command
from hfc_design.simulation.stepping import nested
from hfc_design.simulation.usable import unseen
from hfc_design.stability.frequency import FrequencyResponse, response_units
from plants import Drive

#: Amplitudes of the sines, as shares of the largest command; the machines get the middle one.
SHARES = (0.01, 0.03, 0.1)
#: Number of corrections of the load's amplitude, which is to move the command by the same amount.
CORRECTIONS = 2
#: Length of the window [samples]; time before it in which the loop settles, as a share of it.
WINDOW, SETTLING = 3072, 0.5
#: Share of the settling time in which the machine reaches its speed.
STARTING = 0.3
#: Number of cases that are simulated in one call, so that few and many share a compiled program.
TOGETHER = 4
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


class Setup(NamedTuple):
    """The loop of a design, its machines, and the steady motion in which an axis is excited."""

    name: str  # of the design, and of the axis if there are several
    scenario: Scenario
    loop: Loop
    gains: Gains
    machines: Machines  # the nominal one first
    point: Point
    fastest: Point  # of the scenario, by this axis
    axis: int
    bare: Machines  # those machines without effects around their drives

    @classmethod
    def of(
        cls,
        design: AnyDesign,
        scenario: AnyScenario | None,
        axis: str | None,
        speed: float | None,
        machines: int,
        later: float | None = None,
        seed: int = 0,
    ) -> "Setup":
        """Return the setup; ``later``: see ``closed_loop``; else see ``calls.frequency``.

        ``seed`` is added to that of the machines.
        """
        design = load_design(design)
        where = load_scenario(scenario) if scenario else own_scenario(design, design.name)
        where = with_converter(where, design)
        axes = where.machine.axes
        if axis is not None and axis not in axes:
            raise UserError(f"{option('axis', axis)}: must be one of {', '.join(axes)}")
        number = axes.index(axis) if axis else 0
        controller, gains = controller_of(design, where)
        loop = closed_loop(where, controller, later)
        some = unseen(design, where, machines, seed)
        fastest = max(operating_points(where), key=lambda one: abs(one.speeds[number]))
        point = fastest._replace(row=_from_start(fastest.row, where.machine.drives))
        if speed is not None:
            motion = where.each_motion()[0]
            speeds = tuple(speed if k == number else 0.0 for k in range(len(axes)))
            point = Point("", steady_row(motion, motion.samples(), 0, speeds), speeds)
        name = f"{design.name} {axes[number]}" if len(axes) > 1 else design.name
        around = standing(some, where, loop)
        return cls(name, where, loop, gains, around, point, fastest, number, some)

    @property
    def every(self) -> float:
        """Sample time [s]."""
        return self.scenario.simulation.sample_time_s

    @property
    def largest(self) -> float:
        """The largest command; if unlimited, that of the fastest motion; UserError: neither."""
        drive, axis = self.scenario.machine.drives[self.axis], self.scenario.machine.axes[self.axis]
        limit = largest_command(self.scenario.limits.of(axis))
        largest = drive.largest_commands(self.machines.nominal[self.axis], limit)[1]
        if not np.isfinite(largest):
            about = near(self.loop, self.machines.take(np.zeros(1, int)), [self.fastest])
            largest = float(np.abs(about.commands[0, self.axis]))
        if not largest > 0.0:
            given = option("amplitude", ..., "amplitudes")
            raise UserError(f"{given}: is missing, as the command has no limit")
        return largest


def _from_start(row: Samples, drives: Sequence[Drive]) -> Samples:
    """Return the row for a motion that begins where the machine starts, and not far from there."""
    axes = []
    for one, drive, state in zip(row.axes, drives, row.start, strict=True):
        place = getattr(state, drive.position)
        axes.append(one._replace(reference=place, target=place))
    return row._replace(axes=tuple(axes))


class Sines(NamedTuple):
    """Sines of a case (or of many: a leading axis), as amplitudes in the units of the drive."""

    command: Any
    load: Any  # None: no sines on the load
    shift: Any  # (..., frequencies) of the reference
    overtones: tuple[Any, ...] = ()  # complex; the command's 2nd, 3rd... as shares of its first


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
    overtones: Any  # (overtones, cases, frequencies) of the answer


def simulated_response(
    design: AnyDesign,
    scenario: AnyScenario | None,
    axis: str | None,
    speed: float | None,
    amplitudes: Sequence[float],
    machines: int,
    frequencies: int,
) -> list[FrequencyResponse]:
    """Return the frequency responses of a design's loop at several amplitudes, by stepped sines.

    For the arguments see ``calls.frequency.frequency``.

    Raises:
        UserError: design and scenario do not fit, the axis is unknown, or the command has no limit
            and no amplitude is given.
    """
    return responses(Setup.of(design, scenario, axis, speed, machines), amplitudes, frequencies)


def responses(
    setup: Setup, amplitudes: Sequence[float], frequencies: int
) -> list[FrequencyResponse]:
    """Return a response for each amplitude, see ``simulated_response``."""
    periods, machines = whole_periods(frequencies), setup.machines.size - 1
    sizes = sorted(amplitudes) or [x * setup.largest for x in SHARES]
    middle = (len(sizes) - 1) // 2

    def answers(chosen: Integers, command: Floats, load: Floats) -> Answers:
        sines = Sines(command, load, np.zeros((len(chosen), len(periods))))
        return stepped_sines(setup, setup.machines.take(chosen), sines, periods)

    chosen = np.r_[np.arange(machines + 1), np.zeros(len(sizes) - 1, int)]
    others = sizes[:middle] + sizes[middle + 1 :]
    command, load = np.r_[np.full(machines + 1, sizes[middle]), others], 1.0
    for _ in range(CORRECTIONS):
        first = answers(chosen[:1], command[:1], np.array([load]))
        with np.errstate(all="ignore"):  # nothing moves, or the loop diverges
            more = float(np.abs(first.added / first.resisting).min())
        load *= more if np.isfinite(more) and more > 0.0 else 1.0
    every = answers(chosen, command, command * load / command[0])
    begins = [*range(machines + 1, machines + 1 + len(others))]
    parts = [slice(k, k + 1) for k in begins]
    parts.insert(middle, slice(machines + 1))
    return [_response(setup, every, x, part) for x, part in zip(sizes, parts, strict=True)]


def _response(setup: Setup, answers: Answers, size: float, part: slice) -> FrequencyResponse:
    """Return the response from the answers of some cases, to sines of a ``size``."""
    some: Answers = jax.tree.map(lambda leaf: leaf[part] if leaf.ndim > 1 else leaf, answers)
    units = setup.scenario.units.signals
    with np.errstate(all="ignore"):
        drive, loop = some.seen / some.command, -some.answer / some.command
        about = (drive, some.share[0], response_units(units), loop, some.moved / some.load)
    name = f"{setup.name} {three_digits(size)} {units['command']}"
    return FrequencyResponse(name, some.hertz, setup.every, *about)


class _Shared(NamedTuple):
    """Inputs that all cases share."""

    numbers: Any  # floats of the loop
    nominal: Any
    gains: Gains  # leaves (..., 1)
    row: Samples  # a column of a steady motion at the speeds
    moving: tuple[Floats, ...]  # travel, rate and acceleration, (steps, axes) each
    window: Floats  # (steps,)
    angles: Floats  # (frequencies,) per sample


def stepped_sines(
    setup: Setup, machines: Machines, sines: Sines, periods: Floats, opened: bool = False
) -> Answers:
    """Return the answers of each machine to sines on the command and on the load of the axis.

    Args:
        setup: the loop, and the steady motion.
        machines: a machine for each case; ``standing`` if the loop has effects around its drives.
        sines: of each case.
        periods: (frequencies,) whole numbers of periods in the window, see ``whole_periods``.
        opened: whether the sine replaces the command of the axis, so that its loop is open; the
            controller then answers without limits.
    """
    loop, settling, every = setup.loop, int(SETTLING * WINDOW), setup.every
    begun_at = np.clip(np.arange(settling + WINDOW + 1) / (STARTING * settling), 0.0, 1.0)
    rate = begun_at**2 * (3.0 - 2.0 * begun_at)
    travel, faster = np.cumsum(rate)[:-1] * every, np.diff(rate) / every
    moving = tuple(x[:, None] * np.array(setup.point.speeds) for x in (travel, rate[:-1], faster))
    angles = 2.0 * np.pi * periods / WINDOW
    hann = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(WINDOW) / WINDOW)
    weights = np.concatenate([np.zeros(settling), hann])
    law = unlimited(loop.controller) if opened else loop.controller
    code, numbers = loop._replace(controller=Excited(law, opened)).apart
    about = (numbers, machines.nominal, setup.gains, setup.point.row)
    shared, count = _Shared(*about, moving, weights, angles), machines.size
    width, parts = -(-TOGETHER // jax.device_count()) * jax.device_count(), []
    for begin in range(0, count, width):
        chosen = np.minimum(np.arange(begin, begin + width), count - 1)
        cases = jax.tree.map(lambda leaf, chosen=chosen: leaf[chosen], (machines.actual, sines))
        with own_code_of(loop), np.errstate(all="ignore"):
            parts.append(_sums(code, setup.axis, shared, cases))
    sums = np.moveaxis(np.concatenate(parts)[:count], -1, 0)
    turns = angles[:, None] * np.arange(len(weights))
    unit = (np.cos(turns) * np.exp(-1j * turns)) @ weights
    command, answer, seen, _, *powers, middle = sums[:7, :, : len(angles)]
    begin = 0 if sines.load is None else len(angles)
    resisting, _, _, moved, *_ = sums[..., begin : begin + len(angles)]
    overtones = sums[7:, :, : len(angles)]
    with np.errstate(all="ignore"):
        shares = 2.0 * np.abs([command, answer]) ** 2 / (np.real(powers) * weights.sum())
    share, mean = np.nan_to_num(shares).min(axis=0), middle.real / weights.sum()
    added, load = (0.0 * unit if x is None else x[:, None] * unit for x in sines[:2])
    phasors = (added, command, answer, seen, mean, share, load, moved, resisting, overtones)
    return Answers(angles / (2.0 * np.pi * every), *phasors)


def whole_periods(count: int) -> Floats:
    """Return up to ``count`` whole numbers of periods in the window, evenly on a log scale."""
    return np.unique(np.geomspace(PERIODS, HIGHEST * WINDOW / 2.0, count).round())


@partial(jax.jit, static_argnums=(0, 1), compiler_options=devices.compiler_options())
def _sums(code: Code, axis: int, shared: _Shared, cases: Any) -> Any:
    """Return weighted sums (cases, lanes, 7 or more) over the window, see ``_added``."""
    loop: Loop = joined(code, shared.numbers)
    gains = jax.tree.map(lambda row: row[0], jax.tree.map(nested, shared.gains))
    angles, zeros = shared.angles, jnp.zeros(len(shared.angles))

    def one_case(case: Any) -> Any:
        true, sines = case
        fixed, count = loop.coefficients(true), len(angles) * (1 if sines.load is None else 2)
        none = jnp.zeros(LANES - count % LANES)  # full registers: a third faster
        each: list[tuple[Any, ...]] = [(angles, sines.command + zeros, zeros, sines.shift)]
        if sines.load is not None:
            each.append((angles, zeros, sines.load + zeros, sines.shift))
        each.append((none, none, none, none))
        turned, *lanes = map(jnp.concatenate, zip(*each, strict=True))
        law = gains, (None,) * len(loop.limits)
        first = start(loop, fixed, jnp.zeros(()), shared.row.start, law)
        first = jax.tree.map(lambda leaf: jnp.broadcast_to(leaf, turned.shape), first)
        about = (loop, axis, gains, shared.nominal, fixed)
        move = jax.vmap(partial(_moved, about), in_axes=(0, 0, 0, 0, None, None))
        more, (command, load, shift) = jnp.exp(1j * turned), lanes

        def sample(carry: Any, given: Any) -> Any:
            before, turn, sums = carry
            *moving, weight = given
            row, every = row_at(shared.row, *moving), shared.row.sample_time
            higher = (x * turn ** (2 + k) for k, x in enumerate(sines.overtones))
            now = command * jnp.real(sum(higher, turn))
            after, signals = move(before, turn, turned, Sines(now, load, shift), row, every)
            sums = sums + weight * _added(signals, turn, len(sines.overtones))
            return (after, turn * more, sums), None

        columns = 7 + len(sines.overtones)
        begin = first, jnp.ones_like(more), jnp.zeros((len(more), columns), more.dtype)
        return lax.scan(sample, begin, (*shared.moving, shared.window))[0][2]

    return spread(lambda some: lax.map(one_case, some), CHUNKS, (CHUNKS,))(cases)


def _moved(
    about: Any, before: LoopState, turn: Any, angle: Any, lane: Sines, row: Samples, every: Scalar
) -> tuple[LoopState, tuple[Any, ...]]:
    """Return the state of a lane after a sample, and its signals: see ``Answers``.

    ``about``: loop, axis, gains, assumed parameters and coefficients, which all lanes share.
    """
    loop, axis, gains, nominal, fixed = about
    drive, state, one = loop.machine.drives[axis], before.states[axis], row.axes[axis]
    parts = angle * np.arange(len(one.loads)) / (len(one.loads) - 1.0)
    loads = [
        x + lane.load * jnp.real(turn * jnp.exp(1j * part))
        for x, part in zip(one.loads, parts, strict=True)
    ]
    there = one._replace(loads=tuple(loads), reference=one.reference + lane.shift)
    axes = tuple(there if k == axis else x for k, x in enumerate(row.axes))
    added = tuple(lane.command if k == axis else None for k in range(len(axes)))
    given = (nominal, fixed, every, (gains, added), before, row._replace(axes=axes))
    after = next_state(loop, *given)
    seen = getattr(drive.measured(fixed[axis], state), drive.seen[0])
    signals = after.commands[axis], after.memory[1][axis], seen, getattr(state, drive.position)
    return after, signals


def _added(signals: tuple[Any, ...], turn: Any, overtones: int) -> Any:
    """Return what a sample adds to the sums: 4 phasors, 2 powers, the mean position, overtones.

    The signals of the last lane, which has no sine, are subtracted.
    """
    off = [one - one[-1] for one in signals]
    back = jnp.conj(turn)
    phasors, higher = [x * back for x in off], [off[1] * back ** (2 + k) for k in range(overtones)]
    return jnp.stack([*phasors, off[0] ** 2, off[1] ** 2, off[2], *higher], axis=-1)


def row_at(row: Samples, travel: Any, rate: Any, acceleration: Any) -> Samples:
    """Return the row of a motion that has come so far, in scalars."""
    axes = []
    for k, one in enumerate(row.axes):
        faster = None if one.reference_acceleration is None else acceleration[k]
        now = one._replace(reference=one.reference + travel[k], reference_rate=rate[k])
        now = now._replace(loads=tuple(one.loads), noise=tuple(one.noise))
        axes.append(now._replace(target=now.reference, reference_acceleration=faster))
    return row._replace(axes=tuple(axes))
