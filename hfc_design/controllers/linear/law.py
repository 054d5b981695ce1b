"""The linear law with feed-forward: one text for ``pid+ff``, ``lqr`` and ``lqi``.

Never imports JAX.
"""

from typing import Any, NamedTuple

from hfc_design.controllers.controller import AxisLaw, Signals, held
from hfc_design.core.numbers import Scalar, Xp, clipped, total

#: Signals that every one reads; those that it feeds back stand between.
ERRORS = ("error", "error_rate")
AHEAD = ("reference_rate", "reference_acceleration")


class LinearGains(NamedTuple):
    """One individual, or a population in the trailing axis; units of the command and the drive."""

    kp: Scalar
    ki: Scalar = 0.0
    kd: Scalar = 0.0
    kept: Scalar = 0.0  # share of the filtered rate that a sample keeps; 0: no filter
    #: On the signals of ``AxisLaw.structure``, (signals, n) of a population; None: on none.
    signals: Any = None
    velocity: Scalar = 0.0
    acceleration: Scalar = 0.0
    coulomb: Scalar = 0.0
    width: Scalar = 1.0  # speed of the reference at which the Coulomb part is whole
    load: Scalar = 0.0  # command for the load that is expected


class LinearMemory(NamedTuple):
    """What the controller remembers; zero before the first sample."""

    integral: Scalar  # of the error, in units of the command
    rate: Scalar  # filtered rate of the error


class Parts(NamedTuple):
    """What a command is made of."""

    proportional: Scalar
    integral: Scalar
    derivative: Scalar
    signals: tuple[Scalar, ...]
    velocity: Scalar
    acceleration: Scalar
    coulomb: Scalar
    load: Scalar


def initial_memory(law: AxisLaw, zero: Scalar) -> LinearMemory:
    """Memory before the first sample: the axis stood on its reference."""
    return LinearMemory(zero, zero)


def sample(
    xp: Xp, law: AxisLaw, gains: LinearGains, memory: LinearMemory, signals: Signals
) -> tuple[Scalar, LinearMemory, Parts]:
    """PID on the error, gains on signals, feed-forward of the reference and of a load.

    The integral is that of the samples before this one, so that the command does not depend on
    whether it is held: it stays where the command is beyond its limit and the error would push it
    further (conditional integration; Astrom and Hagglund, PID Controllers, 1995, section 3.5).
    The sign of the speed is a saturation, so that a reversal of the reference is no jump of the
    command, which would strike the transmission (boundary layer; Slotine and Li, Applied Nonlinear
    Control, 1991, section 7.2).
    """
    error, speed = signals["error"], signals["reference_rate"]
    rate = gains.kept * memory.rate + (1.0 - gains.kept) * signals["error_rate"]
    pairs = zip(law.structure, gains.signals or (), strict=True)
    parts = Parts(
        gains.kp * error,
        memory.integral,
        gains.kd * rate,
        tuple(gain * signals[name] for name, gain in pairs),
        gains.velocity * speed,
        gains.acceleration * signals["reference_acceleration"],
        gains.coulomb * clipped(xp, speed / gains.width, -1.0, 1.0),
        gains.load,
    )
    command = total((*parts[:3], *parts.signals, *parts[4:]))
    integral = memory.integral + gains.ki * law.sample_time * error
    integral = held(xp, law.limit, command, memory.integral, integral)
    return command, LinearMemory(integral, rate), parts
