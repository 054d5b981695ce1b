"""Adaptive fuzzy sliding control of an axis (Lin & Gai 2009, cited as LG09).

``u = theta' xi(e, de/dt) + k sat(s / phi)`` with ``s = de/dt + lambda e`` (LG09 eq. 9 to 13). The
consequents theta follow ``dtheta/dt = gamma (E' P_2) xi`` (eq. 14), E = (e, de/dt): the direct
adaptive fuzzy control of Wang (1994), with ``e = reference - position`` as in this package; the e
of eq. 9 has the other sign. Written for one axis in scalars; ``xp`` as in ``core.numbers``. Never
imports JAX.
"""

from collections.abc import Sequence
from operator import add
from typing import NamedTuple

from hfc_design.controllers.controller import AxisLaw, Signals, held
from hfc_design.controllers.neighbours import Degrees, changed, evenly, weighted
from hfc_design.core.numbers import RuleTable, Scalar, Xp, clipped
from hfc_design.core.records import TERMS, ZR


class Pid(NamedTuple):
    """Linear gains in addition to the rules."""

    k_p: Scalar  # [command/error]
    k_i: Scalar  # [command/(error s)]
    k_d: Scalar  # [command s/error]


class SlidingGains(NamedTuple):
    """Numbers of the controller: one individual, or a population in the trailing axis."""

    error_terms: Scalar  # terms that an error of 1 is away from ZZ
    rate_terms: Scalar  # the same of its rate
    consequents: RuleTable  # (7, 7) theta as it was designed [term of e][term of its rate]
    slope: Scalar  # lambda [1/s]
    switching: Scalar  # k, largest command of the switching part
    boundary_layer: Scalar  # phi [error/s]
    adaptation: Scalar  # gamma [command/error]
    judge: Sequence[Scalar]  # (2,) P_2, of the error [1/s] and of its rate [1]
    largest_move: Scalar  # of a consequent from where it was designed, either way
    pid: Pid | None = None
    learnt: RuleTable | None = None  # (7, 7) what of the consequents was learned already


class SlidingMemory(NamedTuple):
    """Memory of the controller; all zero before the first sample."""

    moves: RuleTable  # (7, 7) of the consequents from where they were designed
    sum: Scalar  # of k_i T e


class Parts(NamedTuple):
    """Parts of a command."""

    error: Scalar
    rate: Scalar
    in_error: Degrees  # (7,)
    in_rate: Degrees  # (7,)
    consequents: RuleTable  # (7, 7) at this sample
    sliding: Scalar  # s [error/s]
    fuzzy: Scalar
    switching: Scalar
    pid: Scalar | None  # None: there is none


def sliding(sample_time: float, limit: float | None = None) -> AxisLaw:
    """Return the law of kind ``fuzzy-sliding``."""
    return AxisLaw(sample, initial_memory, sample_time, limit, begin=begun)


def initial_memory(law: AxisLaw, zero: Scalar) -> SlidingMemory:
    """Return the memory before the first sample, without moves."""
    return SlidingMemory([[zero] * TERMS for _ in range(TERMS)], zero)


def begun(xp: Xp, law: AxisLaw, gains: SlidingGains, memory: SlidingMemory) -> SlidingMemory:
    """Return the memory with the moves already learned."""
    learnt = gains.learnt or memory.moves
    return memory._replace(moves=[[memory.sum + move for move in row] for row in learnt])


def sample(
    xp: Xp, law: AxisLaw, gains: SlidingGains, memory: SlidingMemory, signals: Signals
) -> tuple[Scalar, SlidingMemory, Parts]:
    """Return the command of one sample, the memory after it, and the command's parts.

    The consequents of the previous sample give the command; they move afterwards.
    """
    error, rate = signals["error"], signals["error_rate"]
    in_error = degrees(xp, gains.error_terms * error)
    in_rate = degrees(xp, gains.rate_terms * rate)
    consequents = xp.each(add, gains.consequents, memory.moves)
    fuzzy = xp.once(weighted(xp, in_error, in_rate, consequents))
    s = rate + gains.slope * error
    switching = gains.switching * clipped(xp, s / gains.boundary_layer, -1.0, 1.0)
    command, linear, whole = _linear(xp, law, gains.pid, memory, error, rate, fuzzy + switching)
    of_error, of_rate = gains.judge
    step = gains.adaptation * law.sample_time * (of_error * error + of_rate * rate)
    # A command at its limit teaches nothing that would push it further: the table would wind up.
    step = xp.once(held(xp, law.limit, command, 0.0, step))
    moves = _moved(xp, gains, memory.moves, step, in_error, in_rate)
    parts = Parts(error, rate, in_error, in_rate, consequents, s, fuzzy, switching, linear)
    return command, SlidingMemory(moves, whole), parts


def degrees(xp: Xp, place: Scalar) -> Degrees:
    """Return the degrees (7,) of a value ``place`` terms from ZZ; the outermost terms saturate.

    The terms are evenly spaced triangles that reach to their neighbours' centres, so that the
    degrees sum to 1.
    """
    return evenly(xp, clipped(xp, place, -float(ZR), float(ZR)), ZR)


def _moved(
    xp: Xp, gains: SlidingGains, moves: RuleTable, step: Scalar, in_error: Degrees, in_rate: Degrees
) -> RuleTable:
    """The ``moves`` (7, 7) after a ``step`` of LG09 eq. 14, projected on a box.

    The box is the largest move about the designed consequents. The nearest point of a convex set
    is no farther from any point in it: the projection makes no consequent worse (Wang 1994, with a
    ball instead of a box).
    """
    largest = gains.largest_move

    def size(share: Scalar) -> Scalar:
        return xp.once(step * share)

    def moved(size: Scalar, degree: Scalar, move: Scalar) -> Scalar:
        new_move: Scalar = xp.call(_stepped, xp, size, degree, move, largest)
        return new_move

    new_moves: RuleTable = changed(xp, in_error, in_rate, moves, size, moved)
    return new_moves


def _stepped(xp: Xp, size: Scalar, degree: Scalar, move: Scalar, largest: Scalar) -> Scalar:
    """Return the move of a consequent that fires to ``degree``, within its box."""
    return clipped(xp, move + size * degree, -largest, largest)


def _linear(
    xp: Xp,
    law: AxisLaw,
    pid: Pid | None,
    memory: SlidingMemory,
    error: Scalar,
    rate: Scalar,
    rules: Scalar,
) -> tuple[Scalar, Scalar | None, Scalar]:
    """Return the command of ``rules`` and linear gains, the gains' share, and their integral."""
    if pid is None:
        return rules, None, memory.sum
    pd = pid.k_p * error + pid.k_d * rate
    whole = memory.sum + pid.k_i * law.sample_time * error
    whole = held(xp, law.limit, rules + pd + whole, memory.sum, whole)
    return rules + (pd + whole), pd + whole, whole
