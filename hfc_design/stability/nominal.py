"""A drive linearised while it slides: what feed-forward and linear design know of it.

At rest friction is no slope: the bristles of LuGre are a spring there, a dry contact holds still.
At a creep its slope is negative where it falls towards the Coulomb level (Stribeck). So the drive
is linearised at the speed from which on the part of the command that grows with the speed is the
larger one: friction slides there, as it does at every higher speed. ``Drive.step`` itself is
differentiated, in float64; the steps of converters and encoders are no part of it, because a
rounding has the slope 0 everywhere and 1 in the mean. Nor is cogging, which is 0 in the mean over
the way (``averaged``).
"""

from functools import lru_cache
from typing import NamedTuple

import jax
import numpy as np

from hfc_design.core import devices
from hfc_design.core.numbers import Floats, Parameters
from hfc_design.core.plugins import own_code
from hfc_design.core.records import UserError
from hfc_design.stability.margins import balanced
from hfc_design.stability.sliding import RANK, Motion, Slides, Steady, Step, averaged
from plants import Drive

#: Integration steps in a control sample, at first and at most.
SUBSTEPS, MOST_SUBSTEPS = 16, 1024
REFUSED = "the drive {} cannot be linearised: {}"
#: What to do about a drive that never moves steadily, not even in the mean over its way.
UNSTEADY = (
    "a force that depends on the position and is not 0 in the mean, as a spring's, is a likely "
    "reason: leave it out of the model, or take a controller that needs no linear model, as pid"
)
#: A pole so near to the unit circle does not settle by itself.
SETTLES = 1e-9


class Nominal(NamedTuple):
    """A sliding drive near a speed: ``x(k+1) = a x + b u``, held for a control sample.

    The rows of ``outputs`` turn a state into signals; "error" and "error_rate" are those of a
    reference that stands still.
    """

    speed: float  # [of the position, per s]
    a: Floats  # (states, states)
    b: Floats  # (states,)
    outputs: dict[str, Floats]  # (states,) each
    velocity: Steady  # for a unit of it
    acceleration: Steady  # for a unit of it
    coulomb: Steady  # for the direction: what is there at speed 0, by the slope at ``speed``
    load: Steady  # for a unit of it


@lru_cache(maxsize=64)
def nominal(
    drive: Drive, parameters: Parameters, sample_time: float, speed: float | None = None
) -> Nominal:
    """The drive with ``parameters`` near ``speed``, or near the one that is found.

    Raises:
        UserError: it has no steady motion, or cannot be moved from one.
    """
    devices.configure()
    with own_code(" cannot be linearised", ("plant", drive.name)), jax.enable_x64(True):
        slides = Slides(drive, parameters)
        found = _found(slides, sample_time, speed)
        if found is None and (mean := averaged(drive, parameters, sample_time / SUBSTEPS)):
            slides, found = mean, _found(mean, sample_time, speed)
    if found is None:
        at = "any speed" if speed is None else f"{speed:g} {drive.units['error_rate']}"
        why = f"no steady motion was found at {at}; {UNSTEADY}"
        raise UserError(REFUSED.format(drive.name, why))
    motion, one, substeps = found
    a, b, load = _sampled(one, substeps)
    if not _controllable(a, b):
        why = "its command does not move all of what does not settle by itself"
        raise UserError(REFUSED.format(drive.name, why))
    velocity = slides.asks(a, b, sample_time * motion.along)
    rising = 0.5 * sample_time**2 * motion.along + sample_time * velocity.state
    coulomb = Steady(
        motion.command - motion.speed * velocity.command,
        motion.state - motion.speed * velocity.state,
    )
    acceleration, load_own = slides.asks(a, b, rising), slides.asks(a, b, -load)
    parts = (velocity, acceleration, coulomb, load_own)
    return Nominal(motion.speed, a, b, slides.outputs, *parts)


def _found(
    slides: Slides, sample_time: float, speed: float | None
) -> tuple[Motion, Step, int] | None:
    """A steady motion, a step from it, and how many of them make a control sample."""
    dt = sample_time / SUBSTEPS
    if speed is None:
        slowest = slides.slowest(dt)
        if slowest is None:
            return None
        speed = slowest.speed
    substeps = SUBSTEPS
    while slides.fastest(sample_time / substeps) < abs(speed) and substeps < MOST_SUBSTEPS:
        substeps *= 2
    every = sample_time / substeps
    motion = slides.motion(speed, every) or slides.motion(speed, every, slides.slowest(dt))
    return motion and (motion, slides.step(motion.state, motion.command, every), substeps)


def _sampled(one: Step, substeps: int) -> tuple[Floats, Floats, Floats]:
    """State, command and load matrices of so many equal steps."""
    whole, held = np.eye(len(one.a)), np.zeros_like(one.a)
    for _ in range(substeps):
        held = held + whole
        whole = whole @ one.a
    return whole, held @ one.b, held @ one.load


def _controllable(a: Floats, b: Floats) -> bool:
    """Whether the command moves everything that does not settle by itself (Hautus' test)."""
    a, units = balanced(a)
    b = b / units / (np.abs(b / units).max() or 1.0)
    lasting = [pole for pole in np.linalg.eigvals(a) if abs(pole) >= 1.0 - SETTLES]
    each = [np.column_stack([a - pole * np.eye(len(a)), b]) for pole in lasting]
    ranks = [np.linalg.matrix_rank(one, RANK * np.linalg.norm(one, 2)) for one in each]
    return all(rank == len(a) for rank in ranks)
