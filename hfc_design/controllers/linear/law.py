"""Linear law with feed-forward, common to ``pid+ff``, ``lqr`` and ``lqi``.

Never imports JAX.
"""

from typing import Any, NamedTuple, TypeAlias

from hfc_design.controllers.controller import AxisLaw, Signals, held
from hfc_design.core.numbers import Scalar, Xp, clipped, total

#: Signals that every linear law reads, before and after the signals that it feeds back.
ERRORS = ("error", "error_rate")
AHEAD = ("reference_rate", "reference_acceleration")


class Structure(NamedTuple):
    """Structure of the law, which no search varies: ``AxisLaw.structure``."""

    signals: tuple[str, ...] = ()  # that have a gain
    #: Rotation of each resonator in a sample: cosine and sine.
    rotations: tuple[tuple[float, float], ...] = ()


class LinearGains(NamedTuple):
    """Gains in units of command and drive: one individual, or a population in the trailing axis."""

    kp: Scalar
    ki: Scalar = 0.0
    kd: Scalar = 0.0
    filter_pole: Scalar = 0.0  # share of the filtered rate that a sample keeps; 0: no filter
    #: Gains on the signals of ``Structure``, (signals, n) of a population; None: no signals.
    signals: Any = None
    velocity: Scalar = 0.0
    acceleration: Scalar = 0.0
    coulomb: Scalar = 0.0
    width: Scalar = 1.0  # speed of the reference at which the Coulomb part is whole
    load: Scalar = 0.0  # command for the load that is expected
    #: Gains in phase and in quadrature of each resonator of ``Structure``, (resonators, 2, n) of a
    #: population.
    resonators: Any = ()


#: State of a resonator in units of the command: its share, and the share a quarter turn later.
Turning: TypeAlias = tuple[Scalar, Scalar]


class LinearMemory(NamedTuple):
    """Memory of the controller; zero before the first sample."""

    integral: Scalar  # of the error, in units of the command
    rate: Scalar  # filtered rate of the error
    resonators: tuple[Turning, ...] = ()


class Steps(NamedTuple):
    """Increments of the memory by the error of a sample."""

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


def initial_memory(law: AxisLaw, zero: Scalar) -> LinearMemory:
    """Return the memory before the first sample: the axis at rest on its reference."""
    return LinearMemory(zero, zero, ((zero, zero),) * len(law.structure.rotations))


def sample(
    xp: Xp, law: AxisLaw, gains: LinearGains, memory: LinearMemory, signals: Signals
) -> tuple[Scalar, LinearMemory, Parts]:
    """Return the command of one sample, the memory after it, and the command's parts."""
    command, rate, parts = commanded(xp, law, gains, memory, signals)
    steps = driven(law, gains, signals["error"])
    return command, remembered(xp, law, command, memory, rate, steps), parts


def commanded(
    xp: Xp, law: AxisLaw, gains: LinearGains, memory: LinearMemory, signals: Signals
) -> tuple[Scalar, Scalar, Parts]:
    """Return the command: PID, resonators, gains on signals, feed-forward of reference and load.

    Integral and resonators are those of the samples before this one, so that the command does not
    depend on whether they are held. The sign of the speed is a saturation, so that a reversal of
    the reference is no jump of the command, which would strike the transmission (boundary layer;
    Slotine and Li, Applied Nonlinear Control, 1991, section 7.2).

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
    """Return the increments of integral and resonators, by ``factor`` times the gains."""

    def step(gain: Scalar) -> Scalar:
        return factor * gain * law.sample_time * error

    pairs = gains.resonators
    return Steps(step(gains.ki), tuple((step(along), step(ahead)) for along, ahead in pairs))


def remembered(
    xp: Xp, law: AxisLaw, command: Scalar, memory: LinearMemory, rate: Scalar, *steps: Steps
) -> LinearMemory:
    """Return the memory after a sample with the whole ``command``, before its limit.

    The integral is held if the command is beyond its limit and the error would push it further
    (conditional integration; Astrom and Hagglund, PID Controllers, 1995, section 3.5); a resonator
    is not driven there, but oscillates freely.
    """
    integral = total((memory.integral, *(step.integral for step in steps)))
    integral = held(xp, law.limit, command, memory.integral, integral)
    each = zip(law.structure.rotations, memory.resonators, strict=True)
    resonators = tuple(
        _turned(xp, law, command, rotation, before, [step.resonators[k] for step in steps])
        for k, (rotation, before) in enumerate(each)
    )
    return LinearMemory(integral, rate, resonators)


def _turned(
    xp: Xp,
    law: AxisLaw,
    command: Scalar,
    rotation: tuple[Scalar, Scalar],
    before: Turning,
    steps: list[Turning],
) -> Turning:
    """Return a resonator one sample later: the internal model of a sine (Francis and Wonham, 1976).

    ``r(k+1) = rotation r(k) + T error (in_phase, -quadrature)``; where the error is a sine of the
    frequency its share grows by T/2 times the in_phase gain with it, by the quadrature gain a
    quarter turn ahead of it.
    """
    share, behind = before
    along, across = (total(each) for each in zip(*steps, strict=True))
    if law.limit is not None:
        winds = (abs(command) > law.limit) & (along * command > 0.0)
        along, across = (xp.where(winds, 0.0 * step, step) for step in (along, across))
    cosine, sine = rotation
    return cosine * share + sine * behind + along, cosine * behind - sine * share - across
