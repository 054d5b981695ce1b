"""Laws connected to a machine: the code between the machine's readings and its drives.

This code forms the signals of a law from raw readings, as the sensors of the simulator do, and
gives only commands that the converter can output. It can be switched on and off, takes over
smoothly from another controller, and commands 0 after an error was too large. Never imports JAX.
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

#: Inputs of a connected controller besides the readings of its sensors, and their meanings.
SWITCHES = {
    "enable": "the controller is active while this is on, else the command is 0",
    "take_over": "on when enable is switched on: the command starts from the preset and "
    "fades to the controller's",
    "preset": "added to the command, as to hold a vertical axis; or the command taken over",
    "largest_error": "beyond this error the command is 0 until enable goes off; 0 or less: never",
}
#: Names of the ``SWITCHES`` that are true or false; the other ones are numbers.
TRUTHS = ("enable", "take_over")
#: Time constant with which a command that was taken over fades [samples].
FADING = 50.0


class Sensing(NamedTuple):
    """Conversion of an axis's readings to signals of its controller; see ``simulation.sensors``."""

    position: str  # name of the position that is fed back
    velocity: str  # name of the rate of that position
    encoders: dict[str, str]  # name of each angle that an encoder reads -> name of its rate
    rated: tuple[str, ...]  # angles whose rates this code computes from their readings
    resolution: float | None  # step to which encoder readings are rounded; None: no rounding
    source: str  # source of all velocities: "tachometer", "encoder" or "observer"
    samples: int  # samples between two readings whose difference gives a velocity
    observer: tuple[float, float]  # gains alpha and beta of the observer
    turn: float  # one turn of an endless axis; errors stay within half a turn; 0: not endless
    apart: dict[str, float]  # signal with its own sensor -> step of that sensor; 0: no step
    fields: tuple[str, ...]  # names of all readings of the machine's sensors
    #: {reading: value} -> the same readings, as the drive's own sensors report them.
    measured: Callable[[dict[str, Scalar]], dict[str, Scalar]]
    signals: Callable[[dict[str, Scalar]], dict[str, Scalar]]  # readings -> signals of the drive


class Connection(NamedTuple):
    """Sensors and converter between a controller and an axis; None stands for no limit or step."""

    sensing: Sensing
    change: float | None  # largest change of the command from one sample to the next
    step: float | None  # the converter rounds a command to a multiple of this step
    largest: float | None  # largest command that the converter gives


class Begins(NamedTuple):
    """Functions that reset the memory in the first sample after enabling: ``fresh`` is true."""

    #: (xp, fresh, memory) -> the memory; if ``fresh``, with its start values except for arrays.
    rested: Callable[[Xp, Truth, Memory], Memory]
    #: (xp, fresh, memory, first) -> ``first`` if ``fresh``, else ``memory``.
    begun: Callable[[Xp, Truth, Memory, Memory], Memory]

    def memory(self, xp: Xp, fresh: Truth, memory: Memory, first: Callable[..., Memory]) -> Memory:
        """Return the memory that a sample uses; ``first`` makes a first one from a reset one."""
        rested = self.rested(xp, fresh, memory)
        return self.begun(xp, fresh, rested, first(rested))


class Inside(NamedTuple):
    """Structure of a connected law: the law inside, its connection, and its resets."""

    law: AxisLaw
    connection: Connection
    begins: Begins


class DriveMemory(NamedTuple):
    """Memory of the sensors and the command of one axis."""

    angles: dict[str, tuple[Scalar, ...]]  # past readings or estimates of observers, newest first
    rates: dict[str, Scalar]  # velocities estimated by observers
    command: Scalar  # command of the previous sample
    fading: Scalar  # added so that the command starts from one taken over; fades to 0
    taken: Scalar  # 1 if a command was taken over, else 0


class ConnectedMemory(NamedTuple):
    """Memory of a connected controller from one sample to the next."""

    law: Memory
    drive: Any  # a DriveMemory; for a machine a tuple of one for each axis
    running: Scalar  # 1 if the controller was enabled in the previous sample, else 0
    tripped: Scalar  # 1 if an error was too large since the controller was enabled, else 0


def connected(law: AxisLaw, connection: Connection, begins: Begins) -> AxisLaw:
    """Return a law that reads raw readings, forms the signals of ``law`` and runs it."""
    about = law.sample_time, law.limit, Inside(law, connection, begins)
    return AxisLaw(_sample, _start, *about, prime=_primed, begin=_begun)


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
    """Return the command for the drive, the new memory, and the parts of the law's command."""
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
    """Controller of a machine that reads raw readings; it enables all axes together, or none."""

    inner: Controller
    connections: tuple[Connection, ...]
    limits: tuple[float | None, ...]  # largest command of each axis
    sample_time: float
    begins: Begins
    #: (x, y, tangent_x, tangent_y, curvature, root) -> contour error; x, y: actual less commanded.
    contour_error: Callable[..., Scalar]

    @property
    def kind(self) -> str:
        """Name of the kind of the inner controller."""
        return self.inner.kind

    def initial_memory(self, zero: Scalar) -> ConnectedMemory:
        """Return the memory before the first sample."""
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
        """Return the command of each drive, and the new memory."""
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
        """Return the path with the contour error that follows from the errors of x and y."""
        x, y = (-signals["error"] for signals in seen[:2])
        return path._replace(
            contour_error=self.contour_error(x, y, *path.tangent, path.curvature, xp.sqrt)
        )


def _still(sensing: Sensing, zero: Scalar) -> DriveMemory:
    """Return the memory of a drive before the first sample, with all numbers 0."""
    count = sensing.samples if sensing.source == "encoder" else 1
    angles = dict.fromkeys(sensing.rated, (zero,) * count)
    rates = dict.fromkeys(sensing.rated if sensing.source == "observer" else (), zero)
    return DriveMemory(angles, rates, zero, zero, zero)


def _stood(xp: Xp, sensing: Sensing, memory: DriveMemory, signals: Signals) -> DriveMemory:
    """Return the memory as if all past readings of the encoders were equal to the present ones."""
    read = _readings(xp, sensing, signals)
    angles = {angle: (read[angle],) * len(past) for angle, past in memory.angles.items()}
    return memory._replace(angles=angles)


def _enabled(signals: Signals) -> Truth:
    return signals.get("enable", 1.0) > 0.5


def _far(signals: Signals, seen: Signals) -> Truth:
    most = signals.get("largest_error", 0.0)
    return (most > 0.0) & (abs(seen["error"]) > most)


def _tripped(xp: Xp, memory: ConnectedMemory, on: Truth, far: Truth) -> Scalar:
    """Return 1 if an error was too large since the controller was enabled, else 0."""
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
    """Return a drive's command for the ``requested`` one (0 unless it ``runs``), and its memory."""
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
    # Adds 0 times the requested command: nan or infinity remains visible in spite of the limits.
    return command + 0.0 * requested, after


def _readings(xp: Xp, sensing: Sensing, signals: Signals) -> dict[str, Scalar]:
    """Return all readings by name; those of the encoders are rounded to their steps."""
    raw = {name: signals.get(name, 0.0) for name in sensing.fields}
    read = raw | xp.foreign(sensing.measured, raw)
    return read | {
        angle: _in_steps(xp, read[angle], sensing.resolution) for angle in sensing.encoders
    }


def _sensed(
    xp: Xp, sensing: Sensing, every: float, memory: DriveMemory, signals: Signals
) -> tuple[dict[str, Scalar], DriveMemory]:
    """Return the signals of the law and the new memory, as ``simulation.sensors.measured``."""
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
    """Return a difference of two readings of an angle; in an endless axis, that of the short way.

    Real readings may restart at 0 after each turn. Differences below half a turn do not change.
    """
    if not sensing.turn or angle != sensing.position:
        return difference
    return difference - _in_steps(xp, difference, sensing.turn)


def _in_steps(xp: Xp, value: Scalar, step: float | None) -> Scalar:
    return value if not step else step * xp.floor(value / step + 0.5)


def _converted(xp: Xp, connection: Connection, command: Scalar) -> Scalar:
    """Return the output of the converter for a command, as ``simulation.sensors.converted``."""
    if connection.step is None:
        return limited(xp, connection.largest, command)
    whole = _in_steps(xp, command, connection.step)
    if connection.largest is None:
        return whole
    end = xp.where(whole < 0.0, -connection.largest, connection.largest)
    return xp.where(abs(whole) < connection.largest - 0.5 * connection.step, whole, end)
