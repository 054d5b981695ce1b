"""Sensors and converters between the controller and the machine.

Every function computes one axis, with scalars, as in ``closed_loop``.
"""

from math import exp, floor, pi
from typing import NamedTuple

import jax.numpy as jnp

from hfc_design.core.numbers import Parameters, Scalar, State
from hfc_design.files.design import Limits
from hfc_design.files.machine import SensorSettings
from hfc_design.motion.samples import AxisSamples
from plants import Drive

#: By the name of each angle of an axis: earlier readings of the encoder, newest first, or the value
#: that an observer estimates (``Angles``); the velocity that it estimates (``Rates``).
Angles = dict[str, tuple[Scalar, ...]]
Rates = dict[str, Scalar]


class Sensors(NamedTuple):
    """Sensors and converters of an axis."""

    encoder_resolution: float | None  # in the units of the drive; None: ideal
    velocity: str  # where it comes from, see ``SensorSettings``
    observer: tuple[float, float]  # gains alpha and beta of the velocity observer
    readings: tuple[tuple[str, float | None], ...]  # other measured signals, with resolutions
    samples: int = 1  # between two readings whose difference gives the velocity
    turn: float | None = None  # one turn of an endless axis: errors are kept within half of it


def sensors_of(wanted: SensorSettings, sample_time: float) -> Sensors | None:
    """Return the sensors of an axis; None if they are ideal."""
    read = tuple((name, reading.resolution or None) for name, reading in wanted.readings.items())
    exact = wanted.encoder_resolution == wanted.noise == 0.0
    if exact and wanted.velocity == "tachometer" and not (read or wanted.turn):
        return None
    gains = observer_gains(wanted.observer_hz or 0.0, sample_time)
    fields = wanted.encoder_resolution or None, wanted.velocity, gains, read
    return Sensors(*fields, wanted.difference_samples, wanted.turn or None)


def without_steps(sensors: Sensors) -> Sensors:
    """Return the sensors with infinitely fine resolutions."""
    readings = tuple((name, None) for name, _ in sensors.readings)
    return sensors._replace(encoder_resolution=None, readings=readings)


def observer_gains(bandwidth: float, sample_time: float) -> tuple[float, float]:
    """Return gains alpha and beta of an observer with a ``bandwidth`` [Hz] and a sample time [s].

    The observer is a sampled form of the type II tracking loops of resolver-to-digital converters
    and encoder interfaces of drives (Analog Devices, data sheet of the AD2S1210): a critically
    damped alpha-beta filter with both poles at exp(-2 pi f T) (Brookner 1998, sec. 1.3).
    """
    pole = exp(-2.0 * pi * bandwidth * sample_time)
    return 1.0 - pole**2, (1.0 - pole) ** 2


def largest_command(limits: Limits) -> float | None:
    """Return the largest command that the converter can give; None if there is no limit."""
    if limits.command is None or not limits.resolution:
        return limits.command
    steps = limits.command / limits.resolution * (1.0 + 1e-12)
    return limits.resolution * floor(steps) if steps < 2.0**53 else limits.command


def converted(command: Scalar, limit: Scalar | None, step: Scalar | None) -> Scalar:
    """Return a command in whole steps within a limit, which must be a multiple of ``step``."""
    if step is None:
        return command if limit is None else jnp.clip(command, -limit, limit)
    command = in_steps(command, step)
    if limit is None:
        return command
    # Exactly the limit: metrics find a command that is at its limit by comparison.
    inside = jnp.abs(command) < limit - 0.5 * step
    return jnp.where(inside, command, jnp.sign(command) * limit)


def in_steps(value: Scalar, step: Scalar | None) -> Scalar:
    """Return the multiple of ``step`` that is nearest to a value; the value itself for None."""
    return value if step is None else step * jnp.floor(value / step + 0.5)


def folded(sensors: Sensors | None, error: Scalar) -> Scalar:
    """Return the error; on an endless axis (``turn``) reduced to at most half a turn."""
    if sensors is None or sensors.turn is None:
        return error
    return error - in_steps(error, sensors.turn)


def read(
    sensors: Sensors | None, drive: Drive, signals: dict[str, Scalar], row: AxisSamples
) -> dict[str, Scalar]:
    """Return the signals of an axis; those in ``readings`` get the noise and steps of a sensor."""
    signals = signals | {"error": folded(sensors, signals["error"])}
    if sensors is None or not sensors.readings:
        return signals
    noise = row.noise[len(drive.encoders) :]
    each = zip(sensors.readings, noise, strict=True)
    return signals | {
        name: in_steps(signals[name] + disturbance, resolution)
        for (name, resolution), disturbance in each
    }


def measured(
    sensors: Sensors | None,
    drive: Drive,
    fixed: Parameters,
    state: State,
    before: tuple[Angles, Rates],
    row: AxisSamples,
    sample_time: Scalar,
) -> tuple[State, Angles, Rates]:
    """Return the state as measured, and the angles and rates for ``before`` in the next sample.

    Positions are always readings. An observer predicts an angle from its estimated velocity, and
    corrects both by the difference between reading and prediction.
    """
    earlier, rates = before
    state = drive.measured(fixed, state)
    if sensors is None:
        return state, earlier, rates
    alpha, beta = sensors.observer
    seen: dict[str, Scalar] = {}
    angles: Angles = {}
    estimates: Rates = {}
    for (angle, velocity), disturbance in zip(drive.encoders.items(), row.noise, strict=False):
        reading = in_steps(getattr(state, angle) + disturbance, sensors.encoder_resolution)
        known, seen[angle] = earlier[angle], reading
        angles[angle] = (reading, *known[:-1])
        if sensors.velocity == "encoder":
            seen[velocity] = (reading - known[-1]) / (len(known) * sample_time)
        elif sensors.velocity == "observer":
            expected = known[0] + sample_time * rates[angle]
            off = reading - expected
            angles[angle] = (expected + alpha * off,)
            seen[velocity] = estimates[angle] = rates[angle] + beta * off / sample_time
    return state._replace(**seen), angles, estimates
