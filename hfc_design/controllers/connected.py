"""A law of one axis as it is connected: what is between the machine's readings and the drive.

It forms what the law reads of raw readings, as the simulator's sensors do, and keeps a command to
what its converter takes. It is switched on and off, goes over from another controller's command,
and stops where the axis has left its reference too far. Never imports JAX.
"""

from collections.abc import Callable
from math import exp
from typing import Any, NamedTuple

from hfc_design.controllers.controller import FOLLOWED, AxisLaw, Signals, limited, ramped
from hfc_design.core.numbers import Gains, Memory, Scalar, Truth, Xp

#: What a connected controller is told beside its readings, and what that is.
SWITCHES = {
    "enable": "above 0.5 it commands, else the command is 0",
    "take_over": "above 0.5 when it is enabled, it begins with the preset and goes over to its own",
    "preset": "added to the command, as what holds a vertical axis; or what is taken over",
    "largest_error": "where the error is larger, the command is 0 until enable is off; at 0 never",
}
#: Those that are true or false.
TRUTHS = ("enable", "take_over")
#: Time constant with which a command that was taken over fades [samples].
FADING = 50.0


class Sensing(NamedTuple):
    """How the readings of an axis become what its controller reads; see ``simulation.sensors``."""

    position: str  # the reading that is fed back
    velocity: str  # its rate
    encoders: dict[str, str]  # each angle that an encoder reads, and its rate
    rated: tuple[str, ...]  # angles whose rates are formed here
    resolution: float | None  # that all are rounded to; None: not at all
    source: str  # of the velocities: "tachometer", "encoder" or "observer"
    samples: int  # over which the difference of two readings is taken
    observer: tuple[float, float]  # gains alpha and beta
    turn: float  # to half of which the error is folded either way; 0: it is not
    apart: dict[str, float]  # signals that are rounded on their own, and to what
    fields: tuple[str, ...]  # readings: all that the machine's sensors tell
    #: {reading: value} as the machine's own sensors report them, and -> what else is told of them.
    measured: Callable[[dict[str, Scalar]], dict[str, Scalar]]
    told: Callable[[dict[str, Scalar]], dict[str, Scalar]]


class Connection(NamedTuple):
    """What a connected law is made of."""

    law: AxisLaw
    sensing: Sensing
    change: float | None  # largest one of the command in a sample
    step: float | None  # that the converter rounds a command to
    largest: float | None  # that it gives
    #: (xp, fresh, memory) -> the memory with its past forgotten where that is true.
    rested: Callable[[Xp, Truth, Memory], Memory]
    #: (xp, fresh, memory, first) -> the memory, or where that is true the first one.
    begun: Callable[[Xp, Truth, Memory, Memory], Memory]


class ConnectedMemory(NamedTuple):
    """What is remembered from one sample to the next."""

    law: Memory
    angles: dict[str, tuple[Scalar, ...]]  # readings, or what observers made of them, newest first
    rates: dict[str, Scalar]  # of observers
    running: Scalar  # 1 where the sample before was enabled
    command: Scalar  # of the sample before
    fading: Scalar  # what is left of a command that was taken over
    taken: Scalar  # 1 where one was
    tripped: Scalar  # 1 where the error was too large


def connected(connection: Connection, sample_time: float) -> AxisLaw:
    """The law of raw readings."""
    own = connection.law
    return AxisLaw(_sample, _start, sample_time, own.limit, connection, prime=_primed, begin=_begun)


def _start(law: AxisLaw, zero: Scalar) -> ConnectedMemory:
    sensing = law.structure.sensing
    count = sensing.samples if sensing.source == "encoder" else 1
    angles = dict.fromkeys(sensing.rated, (zero,) * count)
    rates = dict.fromkeys(sensing.rated if sensing.source == "observer" else (), zero)
    inner = law.structure.law.initial_memory(zero)
    return ConnectedMemory(inner, angles, rates, zero, zero, zero, zero, zero)


def _begun(xp: Xp, law: AxisLaw, gains: Gains, memory: ConnectedMemory) -> ConnectedMemory:
    return memory._replace(law=law.structure.law.begun(xp, memory.running, gains))


def _primed(
    xp: Xp, law: AxisLaw, gains: Gains, memory: ConnectedMemory, signals: Signals
) -> ConnectedMemory:
    """The machine stood where its encoders read that it is."""
    read = _readings(xp, law.structure.sensing, signals)
    angles = {angle: (read[angle],) * len(past) for angle, past in memory.angles.items()}
    return memory._replace(angles=angles)


def _sample(
    xp: Xp, law: AxisLaw, gains: Gains, memory: ConnectedMemory, signals: Signals
) -> tuple[Scalar, ConnectedMemory, Any]:
    """The command that the drive is to have, what to remember, and what the law made it of."""
    own: Connection = law.structure
    inner = own.law._replace(limit=law.limit, sample_time=law.sample_time)
    seen, angles, rates = _sensed(xp, law, memory, signals)
    on = signals.get("enable", 1.0) > 0.5
    fresh = memory.running < 0.5
    rested = own.rested(xp, fresh, memory.law)
    before = own.begun(xp, fresh, rested, inner.primed(xp, gains, rested, seen))
    asked, after, parts = inner.sample(xp, inner, gains, before, seen)
    command = limited(xp, law.limit, asked)
    taken = xp.where(fresh, xp.where(signals.get("take_over", 0.0) > 0.5, 1.0, 0.0), memory.taken)
    first = xp.where(taken > 0.5, signals.get("preset", 0.0) - command, 0.0)
    fading = xp.where(fresh, first, memory.fading)
    command = command + fading + xp.where(taken > 0.5, 0.0, signals.get("preset", 0.0))
    was = xp.where(fresh, xp.where(taken > 0.5, signals.get("preset", 0.0), 0.0), memory.command)
    command = limited(xp, law.limit, command)
    if own.change is not None:
        command = limited(xp, law.limit, ramped(xp, own.change, was, command))
    most = signals.get("largest_error", 0.0)
    far = (most > 0.0) & (abs(seen["error"]) > most)
    stopped = xp.where(far, 1.0, xp.where(fresh, 0.0, memory.tripped))
    tripped = xp.where(on, stopped, 0.0)
    runs = on & (tripped < 0.5)
    command = xp.where(runs, _converted(xp, own, command), 0.0)
    told = ConnectedMemory(
        after,
        angles,
        rates,
        xp.where(on, 1.0, 0.0),
        command,
        fading * exp(-1.0 / FADING),
        taken,
        tripped,
    )
    # What the law asked for is in it, so that a command that is none is seen behind its limits.
    return command + 0.0 * asked, told, parts


def _readings(xp: Xp, sensing: Sensing, signals: Signals) -> dict[str, Scalar]:
    """What the encoders read, in their steps."""
    raw = {name: signals.get(name, 0.0) for name in sensing.fields}
    read = xp.foreign(sensing.measured, raw)
    return read | {
        angle: _in_steps(xp, read[angle], sensing.resolution) for angle in sensing.encoders
    }


def _sensed(
    xp: Xp, law: AxisLaw, memory: ConnectedMemory, signals: Signals
) -> tuple[dict[str, Scalar], dict[str, tuple[Scalar, ...]], dict[str, Scalar]]:
    """What the law reads; angles and rates to be remembered (``simulation.sensors.measured``)."""
    sensing, every = law.structure.sensing, law.sample_time
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
    found = {name: signals.get(name, 0.0) for name in FOLLOWED}
    found |= xp.foreign(sensing.told, read)
    found |= {name: _in_steps(xp, found[name], step) for name, step in sensing.apart.items()}
    found["error"] = found["reference"] - read[sensing.position]
    found["error"] = _folded(xp, sensing, sensing.position, found["error"])
    found["error_rate"] = found["reference_rate"] - read[sensing.velocity]
    return found, angles, rates


def _folded(xp: Xp, sensing: Sensing, angle: str, difference: Scalar) -> Scalar:
    """A difference of two readings of an angle; of one that begins anew after a turn the short way.

    A simulated reading does not begin anew, and nothing is folded of two that are near.
    """
    if not sensing.turn or angle != sensing.position:
        return difference
    return difference - _in_steps(xp, difference, sensing.turn)


def _in_steps(xp: Xp, value: Scalar, step: float | None) -> Scalar:
    return value if not step else step * xp.floor(value / step + 0.5)


def _converted(xp: Xp, own: Connection, command: Scalar) -> Scalar:
    """What the converter makes of a command (``simulation.sensors.converted``)."""
    if own.step is None:
        return command
    whole = _in_steps(xp, command, own.step)
    if own.largest is None:
        return whole
    end = xp.where(whole < 0.0, -own.largest, own.largest)
    return xp.where(abs(whole) < own.largest - 0.5 * own.step, whole, end)
