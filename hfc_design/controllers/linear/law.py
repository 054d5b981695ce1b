"""The linear law with feed-forward: one text for ``pid+ff``, ``lqr`` and ``lqi``.

Never imports JAX.
"""

from typing import Any, NamedTuple, TypeAlias

from hfc_design.controllers.controller import AxisLaw, Signals, held
from hfc_design.core.numbers import Scalar, Xp, clipped, total

#: Signals that every one reads; those that it feeds back stand between.
ERRORS = ("error", "error_rate")
AHEAD = ("reference_rate", "reference_acceleration")


class Structure(NamedTuple):
    """What no search varies: ``AxisLaw.structure``."""

    signals: tuple[str, ...] = ()  # that have a gain
    #: By what each resonator turns in a sample: cosine and sine.
    rotations: tuple[tuple[float, float], ...] = ()


class LinearGains(NamedTuple):
    """One individual, or a population in the trailing axis; units of the command and the drive."""

    kp: Scalar
    ki: Scalar = 0.0
    kd: Scalar = 0.0
    filter_pole: Scalar = 0.0  # share of the filtered rate that a sample keeps; 0: no filter
    #: On the signals of ``Structure``, (signals, n) of a population; None: on none.
    signals: Any = None
    velocity: Scalar = 0.0
    acceleration: Scalar = 0.0
    coulomb: Scalar = 0.0
    width: Scalar = 1.0  # speed of the reference at which the Coulomb part is whole
    load: Scalar = 0.0  # command for the load that is expected
    #: In phase and in quadrature, of each resonator of ``Structure``: (resonators, 2, n) of a
    #: population.
    resonators: Any = ()


#: A resonator in units of the command: its share of that, and the same a quarter turn later.
Turning: TypeAlias = tuple[Scalar, Scalar]


class LinearMemory(NamedTuple):
    """What the controller remembers; zero before the first sample."""

    integral: Scalar  # of the error, in units of the command
    rate: Scalar  # filtered rate of the error
    resonators: tuple[Turning, ...] = ()


class Steps(NamedTuple):
    """What an error adds in a sample to what is remembered."""

    integral: Scalar
    resonators: tuple[Turning, ...]


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
    resonators: tuple[Scalar, ...] = ()


def initial_memory(law: AxisLaw, zero: Scalar) -> LinearMemory:
    """Memory before the first sample: the axis stood on its reference."""
    return LinearMemory(zero, zero, ((zero, zero),) * len(law.structure.rotations))


def sample(
    xp: Xp, law: AxisLaw, gains: LinearGains, memory: LinearMemory, signals: Signals
) -> tuple[Scalar, LinearMemory, Parts]:
    """The command of one sample, what to remember, and what the command is made of."""
    command, rate, parts = commanded(xp, law, gains, memory, signals)
    steps = driven(law, gains, signals["error"])
    return command, remembered(xp, law, command, memory, rate, steps), parts


def commanded(
    xp: Xp, law: AxisLaw, gains: LinearGains, memory: LinearMemory, signals: Signals
) -> tuple[Scalar, Scalar, Parts]:
    """PID on the error, resonators, gains on signals, feed-forward of the reference and of a load.

    Integral and resonators are those of the samples before this one, so that the command does not
    depend on whether they are held. The sign of the speed is a saturation, so that a reversal of
    the reference is no jump of the command, which would strike the transmission (boundary layer;
    Slotine and Li, Applied Nonlinear Control, 1991, section 7.2).

    Returns:
        The command, the filtered rate of the error, what the command is made of.
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
    """What an error adds to integral and resonators by ``factor`` times these gains."""

    def step(gain: Scalar) -> Scalar:
        return factor * gain * law.sample_time * error

    pairs = gains.resonators
    return Steps(step(gains.ki), tuple((step(along), step(ahead)) for along, ahead in pairs))


def remembered(
    xp: Xp, law: AxisLaw, command: Scalar, memory: LinearMemory, rate: Scalar, *steps: Steps
) -> LinearMemory:
    """What to remember of a sample whose whole ``command``, before its limit, is known.

    The integral stays where the command is beyond its limit and the error would push it further
    (conditional integration; Astrom and Hagglund, PID Controllers, 1995, section 3.5); a resonator
    is not driven there, but turns on.
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
    """A resonator a sample later: the internal model of a sine (Francis and Wonham, 1976).

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
