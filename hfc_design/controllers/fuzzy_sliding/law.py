"""Adaptive fuzzy sliding control of an axis (Lin & Gai 2009, cited as LG09).

``u = theta' xi(e, de/dt) + k sat(s / phi)`` with ``s = de/dt + lambda e`` (LG09 eq. 9 to 13). The
consequents theta follow ``dtheta/dt = gamma (E' P_2) xi`` (eq. 14) with E = (e, de/dt). This is
the direct adaptive fuzzy control of Wang (1994). Here ``e = reference - position``; in eq. 9, e has
the other sign. The law is written for one axis in scalars; ``xp`` as in ``core.numbers``. Never
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

    k_p: Scalar  # gain on the error [command/error]
    k_i: Scalar  # gain on the integral of the error [command/(error s)]
    k_d: Scalar  # gain on the rate of the error [command s/error]


class SlidingGains(NamedTuple):
    """Numbers of one individual; for a population, the last dimension counts individuals."""

    error_terms: Scalar  # distance of an error of 1 from ZZ, counted in terms [1/error]
    rate_terms: Scalar  # distance of a rate of 1 from ZZ, counted in terms [s/error]
    consequents: RuleTable  # (7, 7) designed theta [term of the error][term of its rate]
    slope: Scalar  # lambda of the sliding surface [1/s]
    switching: Scalar  # k, largest command of the switching part [command]
    boundary_layer: Scalar  # phi, half the width of the boundary layer [error/s]
    adaptation: Scalar  # gamma, learning rate [command/error]
    judge: Sequence[Scalar]  # (2,) P_2: weights of the error [1/s] and of its rate [1]
    largest_move: Scalar  # largest move of a consequent from its designed value [command]
    pid: Pid | None = None
    learnt: RuleTable | None = None  # (7, 7) moves learned before this run [command]


class SlidingMemory(NamedTuple):
    """Memory of the controller; all zero before the first sample."""

    moves: RuleTable  # (7, 7) moves of the consequents from their designed values [command]
    sum: Scalar  # sum of k_i T e over the samples [command]


class Parts(NamedTuple):
    """Parts of the command of one sample, and values from which they follow."""

    error: Scalar
    rate: Scalar
    in_error: Degrees  # (7,) degrees of the error
    in_rate: Degrees  # (7,) degrees of its rate
    consequents: RuleTable  # (7, 7) consequents of this sample
    sliding: Scalar  # s [error/s]
    fuzzy: Scalar  # command of the rules
    switching: Scalar  # command of the switching part
    pid: Scalar | None  # command of the linear gains; None: there are none


def sliding(sample_time: float, limit: float | None = None) -> AxisLaw:
    """Return the law of kind ``fuzzy-sliding``."""
    return AxisLaw(sample, initial_memory, sample_time, limit, begin=begun)


def initial_memory(law: AxisLaw, zero: Scalar) -> SlidingMemory:
    """Return the memory before the first sample, without moves."""
    return SlidingMemory([[zero] * TERMS for _ in range(TERMS)], zero)


def begun(xp: Xp, law: AxisLaw, gains: SlidingGains, memory: SlidingMemory) -> SlidingMemory:
    """Return the memory with the moves that ``gains`` contain as already learned."""
    learnt = gains.learnt or memory.moves
    return memory._replace(moves=[[memory.sum + move for move in row] for row in learnt])


def sample(
    xp: Xp, law: AxisLaw, gains: SlidingGains, memory: SlidingMemory, signals: Signals
) -> tuple[Scalar, SlidingMemory, Parts]:
    """Return the command of one sample, the memory after it, and the command's parts.

    The consequents move after they have given the command, and so act in the next sample.
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
    # Beyond the limit a step must not increase the command: the table would wind up.
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
    """The ``moves`` (7, 7) after a ``step`` of LG09 eq. 14, each within the largest move.

    The limits are a box, a convex set: a projection on it increases the distance to no point of the
    box, so also not to the best consequents in it (Wang 1994, with a ball instead of a box).
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
    """Return the limited move of one consequent after ``size * degree`` was added to it."""
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
    """Return the command (``rules`` plus linear gains), that of the gains, and the integral."""
    if pid is None:
        return rules, None, memory.sum
    pd = pid.k_p * error + pid.k_d * rate
    whole = memory.sum + pid.k_i * law.sample_time * error
    whole = held(xp, law.limit, rules + pd + whole, memory.sum, whole)
    return rules + (pd + whole), pd + whole, whole
