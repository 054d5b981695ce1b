"""Parameters under which a machine does what was recorded: many starts, the best ones refined."""

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import NamedTuple, TypeVar

import jax
import numpy as np
from scipy.stats import qmc

from hfc_design.core.numbers import Floats, Scalar
from hfc_design.identify.free import FACTOR, LOAD, OFFSETS, Free
from hfc_design.identify.replay import Replay, Residual

#: Starts that are simulated side by side, and how many of the best are refined.
STARTS, REFINED = 100, 10
#: Where they are drawn: up to so many times the value or its inverse.
AWAY = 5.0
#: Replays of Levenberg-Marquardt that a refined start has, and the last one; and by which share the
#: next one has to make the squares less, or it is the last.
FEW, MANY = 15, 100
LOOSE, TIGHT = 1e-3, 1e-8
#: How much it is damped in the beginning, and at most; and as which share of the one with the
#: largest slope at least, or what is hardly seen would run away.
DAMPING, MOST, WEAK = 1e-3, 1e3, 1e-3
#: The scales are taken anew at most so many times, until none changes by this share.
ROUNDS, SETTLED = 5, 0.02
#: The size of the load is looked for in so many steps.
PUSHED = 4
#: Refined starts that end this near the best one, relative, have found the same.
SAME = 0.01
#: A residual below such a share of the motion is none: of a log without noise all that is left is
#: rounding.
NOTHING = 1e-6
#: How sure it is beforehand that a number is where it began, as a standard deviation. So little
#: that a log that tells anything of it overrules it; what it does not tell stays where it began.
VAGUE = float(np.log(FACTOR))


class Fit(NamedTuple):
    """What was found; numbers are those of ``free``."""

    free: Free
    numbers: Floats  # (names + 2,)
    residual: Floats  # (steps, outputs) recorded less simulated, 0 where it does not count
    jacobian: Floats  # (steps, outputs, names + 2) of the residual
    scale: Floats  # (outputs,) rms of the residual, which weighs each
    agreeing: int  # refined starts that ended with the same residual

    @property
    def rms(self) -> Floats:
        """(outputs,) root mean square of the residual [unit of the output]."""
        return np.asarray(np.sqrt(np.mean(self.residual**2, axis=0)))

    @property
    def late(self) -> float:
        """By how many samples the command acts later than it was recorded."""
        return float(self.numbers[-2])

    @property
    def lag(self) -> float:
        """How much of that is a first-order lag [samples]."""
        return abs(float(self.numbers[-1]))


class Problem(NamedTuple):
    """A residual and what its outputs weigh; one program does for all of a kind and a length."""

    free: Free
    residual: Residual
    scale: Floats  # (outputs,)
    held: Floats  # (names + 2,) 0 where a number stays as it is, else 1

    def off(self, numbers: Scalar) -> Scalar:
        """(steps, outputs) in units of the outputs."""
        return self.residual(*self.free.parts(numbers))

    def squares(self, off: Floats) -> float:
        """Sum of the squares of what it is ``off``, each output in its own scale."""
        with np.errstate(over="ignore", invalid="ignore"):  # a replay may run away
            return float(np.sum(np.square(off / self.scale)))


_off = jax.jit(Problem.off)


@jax.jit
def _both(problem: Problem, numbers: Scalar) -> Scalar:
    def twice(numbers: Scalar) -> tuple[Scalar, Scalar]:
        off = problem.off(numbers)
        return off, off

    return jax.jacfwd(twice, has_aux=True)(numbers)


def offs(problem: Problem, numbers: Floats) -> Floats:
    """``Problem.off``."""
    with jax.enable_x64(True):
        return np.asarray(_off(problem, numbers))


def slopes(problem: Problem, numbers: Floats) -> tuple[Floats, Floats]:
    """``Problem.off``, and its slopes (steps, outputs, names + 2) by what is not held."""
    with jax.enable_x64(True):
        jacobian, off = _both(problem, numbers)
    return np.asarray(off), np.asarray(jacobian) * problem.held


One = TypeVar("One")
Made = TypeVar("Made")


def side_by_side(one: Callable[[One], Made], each: Iterable[One]) -> list[Made]:
    """``one`` of each, on all cores: a replay leaves Python alone."""
    with ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        return [*pool.map(one, each)]


def refined(problem: Problem, numbers: Floats, enough: float, steps: int) -> tuple[Floats, float]:
    """Where Levenberg-Marquardt ends (names + 2,), and the squares there.

    It has ended when a step makes the squares less by a share of ``enough`` only, or would.
    Damped as Nielsen does (Damping parameter in Marquardt's method, IMM-REP-1999-05, 1999).
    """
    free = np.flatnonzero(np.asarray(problem.held))
    begun = np.asarray(problem.free.begun)[free]

    def all_of(off: Floats, numbers: Floats) -> float:
        return problem.squares(off) + float(np.sum(np.square((numbers[free] - begun) / VAGUE)))

    (off, jacobian), damping, growth = slopes(problem, numbers), DAMPING, 2.0
    least, normal = all_of(off, numbers), np.zeros((0, 0))
    for _ in range(steps if np.isfinite(jacobian).all() and np.isfinite(least) else 0):
        if not normal.size:  # here nothing was tried yet
            rows = (jacobian / problem.scale[:, None]).reshape(-1, len(numbers))[:, free]
            slope = rows.T @ (off / problem.scale).ravel()
            slope += VAGUE**-2 * (numbers[free] - begun)
            normal = rows.T @ rows + VAGUE**-2 * np.eye(len(free))
            size = np.maximum(np.diag(normal), WEAK * np.diag(normal).max())
        step = -np.linalg.lstsq(normal + damping * np.diag(size), slope)[0]
        expected = -2.0 * float(step @ slope + 0.5 * step @ normal @ step)
        if expected <= enough * least or damping > MOST:
            break
        trial = numbers.copy()
        trial[free] += step
        there, changed = slopes(problem, trial)
        gained = least - all_of(there, trial)
        if not (gained > 0.0 and np.isfinite(changed).all()):
            damping, growth = damping * growth, 2.0 * growth
            continue
        numbers, off, jacobian, least = trial, there, changed, least - gained
        damping, growth = damping * max(0.1, 1.0 - (2.0 * gained / expected - 1.0) ** 3), 2.0
        normal = np.zeros((0, 0))
        if gained <= enough * least:
            break
    return numbers, least


def weighed(problem: Problem, command: Floats | None) -> Problem:
    """The problem with a constant load in the size of what a ``command`` (steps,) moves.

    What holds the mean of it is near the load: a search begins there.
    """
    free = problem.free
    names = [x for x in (LOAD, *sorted(OFFSETS)) if x in free.names]
    if not names or command is None or not isinstance(problem.residual, Replay):
        return problem
    at = np.array([*(name == names[0] for name in free.names), False, False]) * 1.0
    if free.positive[at[:-2] > 0]:
        return problem
    size, off = float(np.sqrt(np.mean(command**2))), offs(problem, free.begun)
    rows = problem.residual.rows
    more = replace(problem.residual, rows=rows._replace(command=rows.command + size))
    pushed = offs(problem._replace(residual=more), free.begun) - off
    load, held, own = size, 1.0, free
    for _ in range(PUSHED):
        scale = np.where(at[:-2] > 0, load, free.scale)
        begun = np.where(at > 0, free.starts[names[0]] / load, free.begun)
        near = np.where(at > 0, held * np.mean(command) / size, begun)
        own = replace(free, scale=scale, begun=begun, near=near)
        there = problem._replace(free=own)
        pulled = offs(there, begun + at) - off
        both = np.isfinite(pushed) & (pushed != 0.0) & np.isfinite(pulled) & (pulled != 0.0)
        if not both.any():
            return problem
        ratio = float(np.median(pushed[both] / pulled[both])) or -1.0
        load, held = load * abs(ratio), -np.sign(ratio)
    return problem._replace(free=own)


def searched(problem: Problem, seed: int) -> tuple[Floats, int]:
    """Numbers of the best of many starts, and how many of those refined ended like it.

    The first start is that of ``free``; the others are drawn by a Sobol sequence.
    """
    free, random = problem.free, np.random.default_rng(seed)
    drawn = 2.0 * qmc.Sobol(len(free.names), rng=random).random(128)[: STARTS - 1] - 1.0
    away = np.where(free.positive > 0, np.log(AWAY), AWAY) * drawn
    starts = free.near + np.pad(away, [(1, 0), (0, 2)])
    starts = np.where(np.asarray(problem.held) > 0, starts, starts[0])
    count = offs(problem, starts[0]).size
    first = np.array(side_by_side(lambda one: problem.squares(offs(problem, one)), starts))
    first = np.where(np.isfinite(first), first, np.inf)
    if not np.isfinite(first.min()):
        return starts[0], 0
    best = starts[np.argsort(first, kind="stable")[:REFINED]]
    scale = np.sqrt(first.min() / count) * np.asarray(problem.scale)
    close = problem._replace(scale=scale)  # in which what began is not forgotten
    ended = side_by_side(lambda one: refined(close, one, LOOSE, FEW), best)
    squares = np.array([least for _, least in ended]) * first.min() / count
    found = np.sqrt(squares / count)
    agree = found <= max((1.0 + SAME) * found.min(), NOTHING)
    return ended[int(found.argmin())][0], int(agree.sum())


def settled(problem: Problem, numbers: Floats) -> tuple[Problem, Floats]:
    """The problem with each output in the scale of its residual, and the numbers it ends at."""
    scale = np.asarray(problem.scale)
    for k in range(ROUNDS):
        rms = np.sqrt(np.mean(offs(problem, numbers) ** 2, axis=0))
        now = np.maximum(rms, 1e-9 * np.asarray(problem.scale))
        if k and (np.abs(np.log(now / scale)) < SETTLED).all():
            break
        scale = now
        numbers, _ = refined(problem._replace(scale=now), numbers, TIGHT, MANY)
    return problem._replace(scale=scale), numbers


def fitted(problem: Problem, numbers: Floats, agreeing: int) -> Fit:
    """The fit at ``numbers``, with its residual and slopes."""
    residual, jacobian = slopes(problem, numbers)
    return Fit(problem.free, numbers, residual, jacobian, np.asarray(problem.scale), agreeing)
