"""Laws connected to a machine: the code between the machine's readings and its drives.

It forms the signals of a law from raw readings, as the simulator's sensors do, and limits a command
to the values of its converter. It can be switched on and off, takes over smoothly from another
controller's command, and stops when an axis is too far from its reference. Never imports JAX.
"""

from collections.abc import Callable, Sequence
from functools import reduce
from math import exp
from operator import and_, or_
from typing import Any, NamedTuple

from hfc_design.controllers.controller import (
    FOLLOWED,
    AxisLaw,
    Controller,
    PathView,
    Signals,
    Stepped,
    View,
    begun,
    limited,
    primed,
    ramped,
)
from hfc_design.core.numbers import Gains, Memory, Scalar, Truth, Xp

#: What a connected controller is told beside its readings, and what that is.
SWITCHES = {
    "enable": "the controller is active while this is on, else the command is 0",
    "take_over": "on when enable is switched on: the command starts from the preset and "
    "fades to the controller's",
    "preset": "added to the command, as to hold a vertical axis; or the command taken over",
    "largest_error": "beyond this error the command is 0 until enable goes off; 0 or less: never",
}
#: Those that are true or false.
TRUTHS = ("enable", "take_over")
#: Time constant with which a command that was taken over fades [samples].
FADING = 50.0


class Sensing(NamedTuple):
    """Conversion of an axis's readings to signals of its controller; see ``simulation.sensors``."""

    position: str  # the reading that is fed back
    velocity: str  # its rate
    encoders: dict[str, str]  # each angle that an encoder reads, and its rate
    rated: tuple[str, ...]  # angles whose rates are formed here
    resolution: float | None  # that all are rounded to; None: not at all
    source: str  # of the velocities: "tachometer", "encoder" or "observer"
    samples: int  # over which the difference of two readings is taken
    observer: tuple[float, float]  # gains alpha and beta
    turn: float  # to half of which the error is folded either way; 0: it is not
    apart: dict[str, float]  # signals that sensors of their own tell, and their steps; 0: none
    fields: tuple[str, ...]  # readings: all that the machine's sensors tell
    #: {reading: value} as the machine's own sensors report them, and -> what else is told of them.
    measured: Callable[[dict[str, Scalar]], dict[str, Scalar]]
    signals: Callable[[dict[str, Scalar]], dict[str, Scalar]]


class Connection(NamedTuple):
    """Sensors and converter between a controller and an axis."""

    sensing: Sensing
    change: float | None  # largest one of the command in a sample
    step: float | None  # that the converter rounds a command to
    largest: float | None  # that it gives; None: any


class Begins(NamedTuple):
    """Functions that reset a controller's memory."""

    #: (xp, fresh, memory) -> the memory with its past forgotten where that is true.
    rested: Callable[[Xp, Truth, Memory], Memory]
    #: (xp, fresh, memory, first) -> the memory, or where that is true the first one.
    begun: Callable[[Xp, Truth, Memory, Memory], Memory]

    def memory(self, xp: Xp, fresh: Truth, memory: Memory, first: Callable[..., Memory]) -> Memory:
        """The ``memory`` before a sample; ``first`` makes one from a memory without a past."""
        rested = self.rested(xp, fresh, memory)
        return self.begun(xp, fresh, rested, first(rested))


class Inside(NamedTuple):
    """Parts of a connected law."""

    law: AxisLaw
    connection: Connection
    begins: Begins


class DriveMemory(NamedTuple):
    """Memory of a drive."""

    angles: dict[str, tuple[Scalar, ...]]  # readings, or what observers made of them, newest first
    rates: dict[str, Scalar]  # of observers
    command: Scalar  # of the sample before
    fading: Scalar  # what is left of a command that was taken over
    taken: Scalar  # 1 where one was


class ConnectedMemory(NamedTuple):
    """Memory of a connected controller from one sample to the next."""

    law: Memory
    drive: Any  # a DriveMemory, or of a machine those of its axes
    running: Scalar  # 1 where the sample before was enabled
    tripped: Scalar  # 1 where an error was too large


def connected(law: AxisLaw, connection: Connection, begins: Begins) -> AxisLaw:
    """The law as a law of raw readings."""
    return AxisLaw(
        _sample,
        _start,
        law.sample_time,
        law.limit,
        Inside(law, connection, begins),
        prime=_primed,
        begin=_begun,
    )


def _start(law: AxisLaw, zero: Scalar) -> ConnectedMemory:
    wrapped: Inside = law.structure
    drive = _still(wrapped.connection.sensing, zero)
    return ConnectedMemory(wrapped.law.initial_memory(zero), drive, zero, zero)


def _begun(xp: Xp, law: AxisLaw, gains: Gains, memory: ConnectedMemory) -> ConnectedMemory:
    return memory._replace(law=law.structure.law.begun(xp, memory.running, gains))


def _primed(
    xp: Xp, law: AxisLaw, gains: Gains, memory: ConnectedMemory, signals: Signals
) -> ConnectedMemory:
    drive = _stood(xp, law.structure.connection.sensing, memory.drive, signals)
    return memory._replace(drive=drive)


def _sample(
    xp: Xp, law: AxisLaw, gains: Gains, memory: ConnectedMemory, signals: Signals
) -> tuple[Scalar, ConnectedMemory, Any]:
    """The command for the drive, the new memory, and the parts of the law's command."""
    wrapped: Inside = law.structure
    inner = wrapped.law._replace(limit=law.limit, sample_time=law.sample_time)
    seen, drive = _sensed(xp, wrapped.connection.sensing, law.sample_time, memory.drive, signals)
    fresh = memory.running < 0.5
    before = wrapped.begins.memory(
        xp, fresh, memory.law, lambda rested: inner.primed(xp, gains, rested, seen)
    )
    requested, after, parts = inner.sample(xp, inner, gains, before, seen)
    on = _enabled(signals)
    tripped = _tripped(xp, memory, on, _far(signals, seen))
    runs = on & (tripped < 0.5)
    command, drive = _commanded(
        xp, wrapped.connection, law.limit, drive, signals, requested, fresh, runs
    )
    return command, ConnectedMemory(after, drive, xp.where(on, 1.0, 0.0), tripped), parts


class ConnectedMachine(NamedTuple):
    """The controller of a machine, with raw readings: all of its axes are on, or none."""

    inner: Controller
    connections: tuple[Connection, ...]
    limits: tuple[float | None, ...]  # largest command of each axis
    sample_time: float
    begins: Begins
    #: Of x and y, measured less commanded, of tangent and curvature -> the contour error.
    contour_error: Callable[..., Scalar]

    @property
    def kind(self) -> str:
        """Name of the kind inside."""
        return self.inner.kind

    def initial_memory(self, zero: Scalar) -> ConnectedMemory:
        """Memory before the first sample."""
        drives = tuple(_still(connection.sensing, zero) for connection in self.connections)
        return ConnectedMemory(self.inner.initial_memory(zero), drives, zero, zero)

    def begun(self, xp: Xp, zero: Scalar, gains: Gains) -> ConnectedMemory:
        """See ``controller.begun``."""
        return self.initial_memory(zero)._replace(law=begun(self.inner, xp, zero, gains))

    def primed(self, xp: Xp, gains: Gains, memory: ConnectedMemory, view: View) -> ConnectedMemory:
        """See ``controller.primed``."""
        each = zip(self.connections, memory.drive, view.axes, strict=True)
        drives = tuple(_stood(xp, connection.sensing, *one) for connection, *one in each)
        return memory._replace(drive=drives)

    def step(self, xp: Xp, gains: Gains, memory: ConnectedMemory, view: View) -> Stepped:
        """The command of each drive, and the new memory."""
        each = zip(self.connections, memory.drive, view.axes, strict=True)
        sensed = [
            _sensed(xp, connection.sensing, self.sample_time, *one) for connection, *one in each
        ]
        seen, drives = zip(*sensed, strict=True)
        sensed_view = View(seen, view.path and self._path(xp, view.path, seen))
        fresh = memory.running < 0.5
        before = self.begins.memory(
            xp, fresh, memory.law, lambda rested: primed(self.inner, xp, gains, rested, sensed_view)
        )
        requested, after = self.inner.step(xp, gains, before, sensed_view)
        on = reduce(and_, map(_enabled, view.axes))
        tripped = _tripped(xp, memory, on, reduce(or_, map(_far, view.axes, seen)))
        runs = on & (tripped < 0.5)
        rows = zip(self.connections, self.limits, drives, view.axes, requested, strict=True)
        commands, drives = zip(*(_commanded(xp, *row, fresh, runs) for row in rows), strict=True)
        return commands, ConnectedMemory(after, drives, xp.where(on, 1.0, 0.0), tripped)

    def _path(self, xp: Xp, path: PathView, seen: Sequence[Signals]) -> PathView:
        """The path with the contour error that the axes have of it."""
        x, y = (-signals["error"] for signals in seen[:2])
        return path._replace(
            contour_error=self.contour_error(x, y, *path.tangent, path.curvature, xp.sqrt)
        )


def _still(sensing: Sensing, zero: Scalar) -> DriveMemory:
    """Memory of a drive before the first sample."""
    count = sensing.samples if sensing.source == "encoder" else 1
    angles = dict.fromkeys(sensing.rated, (zero,) * count)
    rates = dict.fromkeys(sensing.rated if sensing.source == "observer" else (), zero)
    return DriveMemory(angles, rates, zero, zero, zero)


def _stood(xp: Xp, sensing: Sensing, memory: DriveMemory, signals: Signals) -> DriveMemory:
    """The machine stood where its encoders read that it is."""
    read = _readings(xp, sensing, signals)
    angles = {angle: (read[angle],) * len(past) for angle, past in memory.angles.items()}
    return memory._replace(angles=angles)


def _enabled(signals: Signals) -> Truth:
    return signals.get("enable", 1.0) > 0.5


def _far(signals: Signals, seen: Signals) -> Truth:
    most = signals.get("largest_error", 0.0)
    return (most > 0.0) & (abs(seen["error"]) > most)


def _tripped(xp: Xp, memory: ConnectedMemory, on: Truth, far: Truth) -> Scalar:
    """Whether an error was too large since it is enabled."""
    before = xp.where(memory.running < 0.5, 0.0, memory.tripped)
    return xp.where(on, xp.where(far, 1.0, before), 0.0)


def _commanded(
    xp: Xp,
    connection: Connection,
    limit: float | None,
    memory: DriveMemory,
    signals: Signals,
    requested: Scalar,
    fresh: Truth,
    runs: Truth,
) -> tuple[Scalar, DriveMemory]:
    """Command of a drive from the one that its law ``requested``, and the new memory."""
    command, preset = limited(xp, limit, requested), signals.get("preset", 0.0)
    taken = xp.where(fresh, xp.where(signals.get("take_over", 0.0) > 0.5, 1.0, 0.0), memory.taken)
    first = xp.where(taken > 0.5, preset - command, 0.0)
    fading = xp.where(fresh, first, memory.fading)
    command = command + fading + xp.where(taken > 0.5, 0.0, preset)
    before = xp.where(fresh, xp.where(taken > 0.5, preset, 0.0), memory.command)
    command = limited(xp, limit, command)
    if connection.change is not None:
        command = limited(xp, limit, ramped(xp, connection.change, before, command))
    command = xp.where(runs, _converted(xp, connection, command), 0.0)
    after = memory._replace(command=command, fading=fading * exp(-1.0 / FADING), taken=taken)
    # What the law asked for is in it, so that a command that is none is seen behind its limits.
    return command + 0.0 * requested, after


def _readings(xp: Xp, sensing: Sensing, signals: Signals) -> dict[str, Scalar]:
    """Readings of the encoders, in their steps."""
    raw = {name: signals.get(name, 0.0) for name in sensing.fields}
    read = raw | xp.foreign(sensing.measured, raw)
    return read | {
        angle: _in_steps(xp, read[angle], sensing.resolution) for angle in sensing.encoders
    }


def _sensed(
    xp: Xp, sensing: Sensing, every: float, memory: DriveMemory, signals: Signals
) -> tuple[dict[str, Scalar], DriveMemory]:
    """Signals of the law, and the new memory (``simulation.sensors.measured``)."""
    read = _readings(xp, sensing, signals)
    angles: dict[str, tuple[Scalar, ...]] = {}
    rates: dict[str, Scalar] = {}
    for angle, past in memory.angles.items():
        reading, rate = read[angle], sensing.encoders[angle]
        angles[angle] = (reading, *past[:-1])
        if sensing.source == "encoder":
            read[rate] = _folded(xp, sensing, angle, reading - past[-1]) / (len(past) * every)
        else:
            alpha, beta = sensing.observer
            expected = past[0] + every * memory.rates[angle]
            off = _folded(xp, sensing, angle, reading - expected)
            angles[angle] = (expected + alpha * off,)
            read[rate] = rates[angle] = memory.rates[angle] + beta * off / every
    law_signals = {name: signals.get(name, 0.0) for name in FOLLOWED}
    law_signals |= xp.foreign(sensing.signals, read)
    law_signals |= {name: _in_steps(xp, read[name], step) for name, step in sensing.apart.items()}
    law_signals["error"] = law_signals["reference"] - read[sensing.position]
    law_signals["error"] = _folded(xp, sensing, sensing.position, law_signals["error"])
    law_signals["error_rate"] = law_signals["reference_rate"] - read[sensing.velocity]
    return law_signals, memory._replace(angles=angles, rates=rates)


def _folded(xp: Xp, sensing: Sensing, angle: str, difference: Scalar) -> Scalar:
    """A difference of two readings of an angle: the short way if a reading restarts after a turn.

    Simulated readings do not restart; small differences are not changed.
    """
    if not sensing.turn or angle != sensing.position:
        return difference
    return difference - _in_steps(xp, difference, sensing.turn)


def _in_steps(xp: Xp, value: Scalar, step: float | None) -> Scalar:
    return value if not step else step * xp.floor(value / step + 0.5)


def _converted(xp: Xp, connection: Connection, command: Scalar) -> Scalar:
    """Output of the converter for a command (``simulation.sensors.converted``)."""
    if connection.step is None:
        return limited(xp, connection.largest, command)
    whole = _in_steps(xp, command, connection.step)
    if connection.largest is None:
        return whole
    end = xp.where(whole < 0.0, -connection.largest, connection.largest)
    return xp.where(abs(whole) < connection.largest - 0.5 * connection.step, whole, end)
