"""Linear law with feed-forward, common to ``pid+ff``, ``lqr`` and ``lqi``.

Never imports JAX.
"""

from typing import Any, NamedTuple, TypeAlias

import numpy as np

from hfc_design.controllers.controller import AxisLaw, Signals, held
from hfc_design.core.numbers import Floats, Scalar, Xp, clipped, total

#: Signals that every linear law reads: first ``ERRORS``, then those fed back, then ``AHEAD``.
ERRORS = ("error", "error_rate")
AHEAD = ("reference_rate", "reference_acceleration")


class Structure(NamedTuple):
    """Structure of the law, which no search varies: ``AxisLaw.structure``."""

    signals: tuple[str, ...] = ()  # names of the signals with a gain
    #: Cosine and sine of the angle by which each resonator turns in a sample.
    rotations: tuple[tuple[float, float], ...] = ()
    filters: tuple[str, ...] = ()  # that the command passes: notch, lowpass


class LinearGains(NamedTuple):
    """Gains, in the drive's units: of one individual, or of a population along the last axis."""

    kp: Scalar
    ki: Scalar = 0.0
    kd: Scalar = 0.0
    filter_pole: Scalar = 0.0  # share of the filtered rate that a sample keeps; 0: no filter
    #: Gains on the signals of ``Structure``, (signals, n) of a population; None: no signals.
    signals: Any = None
    velocity: Scalar = 0.0
    acceleration: Scalar = 0.0
    coulomb: Scalar = 0.0
    width: Scalar = 1.0  # speed of the reference at which the Coulomb part is full
    load: Scalar = 0.0  # command against the expected load
    #: Gains in phase and in quadrature of each resonator of ``Structure``, (resonators, 2, n) of a
    #: population.
    resonators: Any = ()
    #: Numbers of each filter of ``Structure``, (filters, 4, n) of a population, see ``section``.
    filters: Any = ()


#: State of a resonator: its share of the command, and that share a quarter of a period later.
Turning: TypeAlias = tuple[Scalar, Scalar]


class LinearMemory(NamedTuple):
    """Memory of the controller; all zero before the first sample."""

    integral: Scalar  # ki x integral of the error, in units of the command
    rate: Scalar  # filtered rate of the error
    resonators: tuple[Turning, ...] = ()
    filters: tuple[tuple[Scalar, Scalar], ...] = ()  # two integrals of each filter


class Steps(NamedTuple):
    """Increments of integral and resonators by the error of a sample."""

    integral: Scalar
    resonators: tuple[Turning, ...]


class Parts(NamedTuple):
    """Parts of a command."""

    proportional: Scalar
    integral: Scalar
    derivative: Scalar
    signals: tuple[Scalar, ...]
    velocity: Scalar
    acceleration: Scalar
    coulomb: Scalar
    load: Scalar
    resonators: tuple[Scalar, ...] = ()
    filters: Scalar = 0.0  # what the filters add


def initial_memory(law: AxisLaw, zero: Scalar) -> LinearMemory:
    """Return the memory before the first sample: the axis at rest on its reference."""
    each = (law.structure.rotations, law.structure.filters)
    return LinearMemory(zero, zero, *(((zero, zero),) * len(x) for x in each))


def sample(
    xp: Xp, law: AxisLaw, gains: LinearGains, memory: LinearMemory, signals: Signals
) -> tuple[Scalar, LinearMemory, Parts]:
    """Return the command of one sample, the memory after it, and the command's parts."""
    command, rate, parts = commanded(xp, law, gains, memory, signals)
    command, memory, parts = filtered(law, gains, memory, command, parts)
    steps = driven(law, gains, signals["error"])
    return command, remembered(xp, law, command, memory, rate, steps), parts


def section(every: float, hz: Scalar, width: Scalar = 2.0**0.5, depth: Scalar = 1.0) -> Floats:
    """Return the numbers (4, n) of a notch of this width and gain at ``hz``, or of a low-pass.

    Both are bilinear transforms of analog filters, exact at ``hz``. Their states are integrals,
    with which single precision is accurate at any frequency.
    """
    slope = np.tan(np.pi * every * hz)
    first = 1.0 / (1.0 + slope * (slope + width))
    numbers = first, slope * first, slope**2 * first, (depth - 1.0) * width
    return np.stack(np.broadcast_arrays(*numbers))


def filtered(
    law: AxisLaw, gains: LinearGains, memory: LinearMemory, command: Scalar, parts: Parts
) -> tuple[Scalar, LinearMemory, Parts]:
    """Return the command after all filters, the memory and the parts with them."""
    states = []
    each = zip(law.structure.filters, gains.filters, memory.filters, strict=True)
    for kind, (a, b, c, band), (first, second) in each:
        off = command - second
        middle, low = a * first + b * off, second + b * first + c * off
        states.append((2.0 * middle - first, 2.0 * low - second))
        after = low if kind == "lowpass" else command + band * middle
        parts, command = parts._replace(filters=parts.filters + (after - command)), after
    return command, memory._replace(filters=tuple(states)), parts


def commanded(
    xp: Xp, law: AxisLaw, gains: LinearGains, memory: LinearMemory, signals: Signals
) -> tuple[Scalar, Scalar, Parts]:
    """Return the command: PID, resonators, gains on signals, feed-forward of reference and load.

    Integral and resonators are those of the previous samples, so that the command does not depend
    on whether they are held. The Coulomb part follows a saturation of the reference's speed, not
    its sign, with which the command would jump at a reversal and strike the transmission (boundary
    layer; Slotine and Li, Applied Nonlinear Control, 1991, section 7.2).

    Returns:
        The command, the filtered rate of the error, the parts of the command.
    """
    speed = signals["reference_rate"]
    rate = gains.filter_pole * memory.rate + (1.0 - gains.filter_pole) * signals["error_rate"]
    pairs = zip(law.structure.signals, gains.signals or (), strict=True)
    parts = Parts(
        gains.kp * signals["error"],
        memory.integral,
        gains.kd * rate,
        tuple(gain * signals[name] for name, gain in pairs),
        gains.velocity * speed,
        gains.acceleration * signals["reference_acceleration"],
        gains.coulomb * clipped(xp, speed / gains.width, -1.0, 1.0),
        gains.load,
        tuple(share for share, _ in memory.resonators),
    )
    command = total((*parts[:3], *parts.signals, *parts[4:8], *parts.resonators))
    return command, rate, parts


def driven(law: AxisLaw, gains: LinearGains, error: Scalar, factor: Scalar = 1.0) -> Steps:
    """Return the increments of integral and resonators, with ``factor`` times their gains."""

    def step(gain: Scalar) -> Scalar:
        return factor * gain * law.sample_time * error

    pairs = gains.resonators
    return Steps(step(gains.ki), tuple((step(along), step(ahead)) for along, ahead in pairs))


def remembered(
    xp: Xp, law: AxisLaw, command: Scalar, memory: LinearMemory, rate: Scalar, *steps: Steps
) -> LinearMemory:
    """Return the memory after a sample with this ``command``, not yet limited, and these ``steps``.

    If the command is beyond its limit and a step would push it further, the integral is held
    (conditional integration; Astrom and Hagglund, PID Controllers, 1995, section 3.5), and a
    resonator is not driven, but oscillates freely.
    """
    integral = total((memory.integral, *(step.integral for step in steps)))
    integral = held(xp, law.limit, command, memory.integral, integral)
    each = zip(law.structure.rotations, memory.resonators, strict=True)
    resonators = tuple(
        _turned(xp, law, command, rotation, before, [step.resonators[k] for step in steps])
        for k, (rotation, before) in enumerate(each)
    )
    return LinearMemory(integral, rate, resonators, memory.filters)


def _turned(
    xp: Xp,
    law: AxisLaw,
    command: Scalar,
    rotation: tuple[Scalar, Scalar],
    before: Turning,
    steps: list[Turning],
) -> Turning:
    """Return a resonator one sample later: the internal model of a sine (Francis and Wonham, 1976).

    ``r(k+1) = rotation r(k) + T error (in_phase, -quadrature)``. For an error sin(w t) of the
    frequency w, the share of the command grows in every sample by T/2 in_phase sin(w t) and by
    T/2 quadrature cos(w t), which is a quarter turn ahead.
    """
    share, behind = before
    along, across = (total(each) for each in zip(*steps, strict=True))
    if law.limit is not None:
        winds = (abs(command) > law.limit) & (along * command > 0.0)
        along, across = (xp.where(winds, 0.0 * step, step) for step in (along, across))
    cosine, sine = rotation
    return cosine * share + sine * behind + along, cosine * behind - sine * share - across
