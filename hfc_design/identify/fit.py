"""Parameters under which a machine does what was recorded, by the observer that tells most.

Many starts, the best ones refined.
"""

import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from typing import NamedTuple, TypeVar

import jax
import numpy as np
from scipy.signal import fftconvolve, lfilter
from scipy.stats import qmc

from hfc_design.core.numbers import Floats, Mask, Scalar, within
from hfc_design.identify.parameters import FACTOR, LOAD, OFFSETS, FreeParameters
from hfc_design.identify.recording import Recording
from hfc_design.identify.replay import DAMPED, Replay, Residual, replay

#: Starts that are simulated side by side, and how many of the best are refined.
STARTS, REFINED = 100, 10
#: Where they are drawn: up to so many times the value or its inverse.
AWAY = 5.0
#: Replays of Levenberg-Marquardt that a refined start has, and the last one; and by which share the
#: next one has to make the squares less, or it is the last.
FEW, MANY = 15, 100
LOOSE, TIGHT = 1e-3, 1e-8
#: How much it is damped in the beginning, and at most; and as which share of the one with the
#: largest slope at least, or what is hardly seen would run away. Steeper slopes have no squares.
DAMPING, MOST, WEAK, STEEP = 1e-3, 1e3, 1e-3, 1e130
#: The scales are taken anew at most so many times, until none changes by this share.
ROUNDS, SETTLED = 5, 0.02
#: The size of the load is looked for in so many steps.
PUSHED = 3
#: Refined starts that end this near the best one, relative, have found the same.
SAME = 0.01
#: A residual below such a share of the motion is none: of a log without noise all that is left is
#: rounding.
NOTHING = 1e-6
#: How sure it is beforehand that a number is where it began, as a standard deviation. So little
#: that a log that tells anything of it overrules it; what it does not tell stays where it began.
VAGUE = float(np.log(FACTOR))
#: Correlations of the residual are counted up to this share of the log, as Newey and West do with
#: weights that fall to 0.
CORRELATED = 0.02
#: Bandwidths of the observer that are tried [Hz], none faster than this share of the samples and
#: none slower than so many periods in the log: the first three do not count.
BANDWIDTHS, SHARE, PERIODS = (50.0, 20.0, 5.0), 0.1, 10.0
#: One that is asked for may be this share of the samples; a faster one does not settle.
LARGEST_SHARE = 0.2
#: A slower observer is tried if under the numbers of the faster one it is off by less than so many
#: times as much; whoever knows the machine needs no fast one.
WORTH = 3.0
#: Where a fit leaves this share of what its observer alone does, as beside a soft spring, slower
#: observers [Hz] are tried from all starts.
SPOILT, SLOWER = 0.4, (5.0, 2.0)
#: A lag is looked for from so many samples, and is one if it is so many standard errors long.
LAG, CLEAR = 0.5, 4.0

One = TypeVar("One")
Made = TypeVar("Made")
#: Is called with a line at every step.
Tell = Callable[[str], None]


def silent(line: str) -> None:
    """Tells nobody."""


class Problem(NamedTuple):
    """A residual and what its outputs weigh; one program does for all of a kind and a length."""

    free: FreeParameters
    residual: Residual
    scale: Floats  # (outputs,)
    moves: Floats  # (names + 2,) 0 where a number stays as it is, else 1
    bandwidth: float | None  # of the observer [Hz]; 0: open loop; None: the closed loop

    def off(self, numbers: Scalar) -> Scalar:
        """(steps, outputs) in units of the outputs."""
        return self.residual(*self.free.parts(numbers))

    def squares(self, off: Floats) -> float:
        """Sum of the squares of what it is ``off``, each output in its own scale."""
        with np.errstate(over="ignore", invalid="ignore"):  # a replay may run away
            return float(np.sum(np.square(off / self.scale)))

    @property
    def observer(self) -> str:
        """What a recording is replayed with, in words."""
        if self.bandwidth is None:
            return "closed loop"
        return f"observer of {self.bandwidth:g} Hz" if self.bandwidth else "open loop"


class Fit(NamedTuple):
    """What was found; numbers are those of ``free``."""

    problem: Problem
    numbers: Floats  # (names + 2,)
    residual: Floats  # (steps, outputs) recorded less simulated, 0 where it does not count
    jacobian: Floats  # (steps, outputs, names + 2) of the residual
    agreeing: int  # refined starts that ended with the same residual

    @property
    def free(self) -> FreeParameters:
        """The parameters that were looked for."""
        return self.problem.free

    @property
    def how(self) -> str:
        """How a log is replayed, in words."""
        command = "" if self.problem.bandwidth is None else "recorded command, "
        return command + self.problem.observer

    @property
    def rms(self) -> Floats:
        """(outputs,) root mean square of the residual [unit of the output]."""
        return rms(self.residual)

    @property
    def values(self) -> Floats:
        """(names,) what was found, in units of the drive."""
        return np.asarray(self.free.values(self.numbers))

    @property
    def late(self) -> float:
        """By how many samples the command acts later than it was recorded."""
        return float(self.numbers[-2])

    @property
    def lag(self) -> float:
        """How much of that is a first-order lag [samples]."""
        return abs(float(self.numbers[-1]))


def rms(residual: Floats) -> Floats:
    """(outputs,) root mean square of (steps, outputs)."""
    return np.asarray(np.sqrt(np.mean(residual**2, axis=0)))


_off = jax.jit(Problem.off)


@jax.jit
def _both(problem: Problem, numbers: Scalar) -> Scalar:
    def twice(numbers: Scalar) -> tuple[Scalar, Scalar]:
        off = problem.off(numbers)
        return off, off

    return jax.jacfwd(twice, has_aux=True)(numbers)


def residuals(problem: Problem, numbers: Floats) -> Floats:
    """``Problem.off``."""
    with jax.enable_x64(True):
        return np.asarray(_off(problem, numbers))


def slopes(problem: Problem, numbers: Floats) -> tuple[Floats, Floats]:
    """``Problem.off``, and its slopes (steps, outputs, names + 2) by what moves."""
    with jax.enable_x64(True):
        jacobian, off = _both(problem, numbers)
    return np.asarray(off), np.asarray(jacobian) * problem.moves


def side_by_side(one: Callable[[One], Made], many: Iterable[One]) -> list[Made]:
    """``one`` of each, on all cores: a replay leaves Python alone."""
    with ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        return [*pool.map(one, many)]


def levenberg_marquardt(
    problem: Problem, numbers: Floats, enough: float, steps: int
) -> tuple[Floats, float]:
    """Where Levenberg-Marquardt ends (names + 2,), and the squares there.

    It has ended when a step makes the squares less by a share of ``enough`` only, or would.
    Damped as Nielsen does (Damping parameter in Marquardt's method, IMM-REP-1999-05, 1999).
    """
    moving = np.flatnonzero(problem.moves)
    begun = np.asarray(problem.free.begun)[moving]

    def all_of(off: Floats, numbers: Floats) -> float:
        return problem.squares(off) + float(np.sum(np.square((numbers[moving] - begun) / VAGUE)))

    (off, jacobian), damping, growth = slopes(problem, numbers), DAMPING, 2.0
    least, normal = all_of(off, numbers), np.zeros((0, 0))
    for _ in range(steps if np.abs(jacobian).max() < STEEP and np.isfinite(least) else 0):
        if not normal.size:  # here nothing was tried yet
            rows = (jacobian / problem.scale[:, None]).reshape(-1, len(numbers))[:, moving]
            slope = rows.T @ (off / problem.scale).ravel()
            slope += VAGUE**-2 * (numbers[moving] - begun)
            normal = rows.T @ rows + VAGUE**-2 * np.eye(len(moving))
            size = np.maximum(np.diag(normal), WEAK * np.diag(normal).max())
        step = -np.linalg.lstsq(normal + damping * np.diag(size), slope)[0]
        expected = -2.0 * float(step @ slope + 0.5 * step @ normal @ step)
        if expected <= enough * least or damping > MOST:
            break
        trial = numbers.copy()
        trial[moving] += step
        there, changed = slopes(problem, trial)
        gained = least - all_of(there, trial)
        if not (gained > 0.0 and np.abs(changed).max() < STEEP):
            damping, growth = damping * growth, 2.0 * growth
            continue
        numbers, off, jacobian, least = trial, there, changed, least - gained
        damping, growth = damping * max(0.1, 1.0 - (2.0 * gained / expected - 1.0) ** 3), 2.0
        normal = np.zeros((0, 0))
        if gained <= enough * least:
            break
    return numbers, least


def with_load_scale(problem: Problem, command: Floats | None) -> tuple[Problem, Floats]:
    """The problem with a constant load in the size of what a ``command`` (steps,) moves.

    What holds the mean of it is near the load: at these numbers (names + 2,) a search begins.
    """
    free, begun = problem.free, problem.free.begun
    k = next((free.names.index(x) for x in (LOAD, *sorted(OFFSETS)) if x in free.names), None)
    if k is None or free.positive[k] or command is None or not isinstance(problem.residual, Replay):
        return problem, begun
    size, off = float(np.sqrt(np.mean(command**2))), residuals(problem, begun)
    rows, at = problem.residual.rows, np.arange(len(begun)) == k
    more = replace(problem.residual, rows=rows._replace(command=rows.command + size))
    pushed = residuals(problem._replace(residual=more), begun) - off
    load, sign = size, 1.0
    for _ in range(PUSHED):
        pulled = residuals(problem, begun + at * load / free.scale[k]) - off
        both = np.isfinite(pushed) & (pushed != 0.0) & np.isfinite(pulled) & (pulled != 0.0)
        if not both.any():
            return problem, begun
        ratio = float(np.median(pushed[both] / pulled[both])) or -1.0
        load, sign = load * abs(ratio), -np.sign(ratio)
    scale = np.where(at[:-2], load, free.scale)
    begun = np.where(at, free.starts[free.names[k]] / load, begun)
    near = np.where(at, sign * np.mean(command) / size, begun)
    return problem._replace(free=replace(free, scale=scale, begun=begun)), near


def multistart(problem: Problem, near: Floats, seed: int) -> tuple[Floats, int]:
    """Numbers of the best of many starts, and how many of those refined ended like it.

    The first start is ``near``; the others are drawn around it by a Sobol sequence.
    """
    free, random = problem.free, np.random.default_rng(seed)
    drawn = 2.0 * qmc.Sobol(len(free.names), rng=random).random(128)[: STARTS - 1] - 1.0
    away = np.where(free.positive > 0, np.log(AWAY), AWAY) * drawn
    starts = near + np.pad(away, [(1, 0), (0, 2)])
    starts = np.where(problem.moves > 0, starts, starts[0])
    count = residuals(problem, starts[0]).size
    first = np.array(side_by_side(lambda one: problem.squares(residuals(problem, one)), starts))
    first = np.where(np.isfinite(first), first, np.inf)
    if not np.isfinite(first.min()):
        return starts[0], 0
    best = starts[np.argsort(first, kind="stable")[:REFINED]]
    scale = np.sqrt(first.min() / count) * problem.scale
    close = problem._replace(scale=scale)  # in which what began is not forgotten
    ended = side_by_side(lambda one: levenberg_marquardt(close, one, LOOSE, FEW), best)
    squares = np.array([least for _, least in ended]) * first.min() / count
    root = np.sqrt(squares / count)
    agree = root <= max((1.0 + SAME) * root.min(), NOTHING)
    return ended[int(root.argmin())][0], int(agree.sum())


def settled(problem: Problem, numbers: Floats, agreeing: int = 0, tell: Tell = silent) -> Fit:
    """The fit that ``numbers`` end at, each output in the scale of its residual."""
    tell(f"{problem.observer}: refining the best")
    scale = problem.scale
    for k in range(ROUNDS):
        now = np.maximum(rms(residuals(problem, numbers)), 1e-9 * problem.scale)
        if k and (np.abs(np.log(now / scale)) < SETTLED).all():
            break
        scale = now
        numbers, _ = levenberg_marquardt(problem._replace(scale=now), numbers, TIGHT, MANY)
    return fitted(problem._replace(scale=scale), numbers, agreeing)


def fitted(problem: Problem, numbers: Floats, agreeing: int = 0) -> Fit:
    """The fit at ``numbers``, with its residual and slopes."""
    return Fit(problem, numbers, *slopes(problem, numbers), agreeing)


def refitted(fit: Fit, numbers: Floats, moving: Mask) -> Fit:
    """Fitted again from ``numbers`` (names + 2,), of which only ``moving`` (names,) ones move.

    Those of ``LATE`` move if they did.
    """
    moves = np.append(moving.astype(float), fit.problem.moves[-2:])
    return settled(fit.problem._replace(moves=moves), numbers, fit.agreeing)


def covariance_of(fit: Fit) -> tuple[Floats, Floats]:
    """(numbers, numbers) of the numbers; of each its variance over that under white noise.

    In the slopes' singular directions: none is lost beside a far larger one, as it would be in
    the normal matrix, and what comes out is a square.
    """
    numbers = len(fit.numbers)
    rows = np.vstack([rows_of(fit.jacobian, fit.problem.scale), np.eye(numbers) / VAGUE])
    left, sizes, right = np.linalg.svd(rows, full_matrices=False)
    basis, before = left[:-numbers].reshape(fit.jacobian.shape), left[-numbers:]
    middle = before.T @ before
    for k, scale in enumerate(fit.problem.scale):
        middle += _correlated(fit.residual[:, k] / scale, basis[:, k])
    inverse = right.T / sizes  # root of the covariance under white noise
    lengths, directions = np.linalg.eigh(middle)
    root = inverse @ (directions * np.sqrt(np.maximum(lengths, 0.0)))
    return root @ root.T, np.sum(root**2, axis=1) / np.sum(inverse**2, axis=1)


def rows_of(slopes: Floats, scale: Floats) -> Floats:
    """(steps outputs, numbers) slopes of residuals that have a deviation of 1."""
    return np.asarray((slopes / scale[:, None]).reshape(-1, slopes.shape[-1]))


def _correlated(residual: Floats, slopes: Floats) -> Floats:
    """(numbers, numbers) variance of the slopes times noise that is as coloured as the residual."""
    steps = len(residual)
    lags = max(int(CORRELATED * steps), 1)
    products = fftconvolve(residual, residual[::-1])[steps - 1 :] / steps
    weighted = products[:lags] * (1.0 - np.arange(lags) / lags)
    both = np.r_[weighted[:0:-1], weighted]
    spread = np.stack([fftconvolve(column, both, "same") for column in slopes.T], axis=1)
    return np.asarray(slopes.T @ spread)


def by_starts(
    free: FreeParameters,
    log: Recording,
    residual: Residual,
    bandwidth: float | None,
    seed: int,
    tell: Tell = silent,
    near: bool = False,
) -> Fit:
    """By many starts, or from one that is ``near``; a delay is looked for but in a closed loop."""
    size = np.array([max(np.std(values), 1e-300) for values in log.outputs.values()])
    late = free.sought[0] if bandwidth is not None else 0.0
    moves = np.append(np.ones(len(free.names)), [late, 0.0])
    problem, numbers = with_load_scale(Problem(free, residual, size, moves, bandwidth), log.command)
    if near:
        return settled(problem, numbers, 0, tell)
    tell(f"{problem.observer}: a hundred starts, refining the best ten")
    return settled(problem, *multistart(problem, numbers, seed), tell)


def by_command(
    free: FreeParameters,
    log: Recording,
    substeps: int,
    tried: Sequence[float],
    seed: int,
    tell: Tell = silent,
    near: bool = False,
) -> Fit:
    """Under the command that was recorded, by the observer of the least residual.

    ``tried`` are their ``bandwidths``. ``near``: the machine is known to be near the first start,
    no others are tried.
    """
    first, *others = tried
    best = by_starts(free, log, replay(free, log, first, substeps), first, seed, tell, near)
    for hz in others:
        residual = replay(best.free, log, hz, substeps)
        problem = best.problem._replace(residual=residual, bandwidth=hz)
        off = residuals(problem, best.numbers)
        if not np.sqrt(np.mean(off[:, 0] ** 2)) < WORTH * best.rms[0]:
            break
        if best.rms[0] <= NOTHING * np.std(log.place):
            break  # of which observer there is less is rounding
        again = settled(problem, best.numbers, best.agreeing, tell)
        if again.rms[0] < best.rms[0]:  # by the position
            best = again
    for hz in SLOWER if others else ():
        if unexplained(best, log) > SPOILT and hz * log.duration >= PERIODS:
            slow = by_starts(free, log, replay(free, log, hz, substeps), hz, seed, tell)
            best = min(best, slow, key=partial(unexplained, log=log))
    return _with_lag(best)


def unexplained(fit: Fit, log: Recording) -> float:
    """What a fit leaves of the position, as a share of what its observer does without a machine."""
    w = 2.0 * np.pi * (fit.problem.bandwidth or 0.0) * log.sample_time
    poles = [1.0, 2.0 * DAMPED * w - 2.0, 1.0 - 2.0 * DAMPED * w + w * w]
    alone = lfilter([1.0, -2.0, 1.0], poles, log.place - log.place[0])
    return float(fit.rms[0] / max(np.sqrt(np.mean(alone**2)), 1e-300))


def _with_lag(fit: Fit) -> Fit:
    """The fit with a part of the lateness as a lag, where the log tells one from the other."""
    moves = fit.problem.moves.copy()
    if not (fit.free.sought[1] and moves[-2]) or fit.lag:
        return fit
    moves[-1] = 1.0
    problem = fit.problem._replace(moves=moves)
    again = settled(problem, np.append(fit.numbers[:-1], LAG), fit.agreeing)
    error = np.sqrt(covariance_of(again)[0][-1, -1])
    return again if again.lag > CLEAR * error and again.rms[0] < fit.rms[0] else fit


def bandwidths(log: Recording, wanted: float | None) -> list[float]:
    """Those of the observers to try [Hz], the fastest first; the one that is ``wanted``.

    Raises:
        ValueError: the log is too short for an observer, or for this one, or too slow.
    """
    low, share = PERIODS / log.duration, SHARE if wanted is None else LARGEST_SHARE
    high = share / log.sample_time
    if wanted is not None:
        if wanted and not within(low, wanted, high):
            raise ValueError(
                f"the observer must have {low:.3g} to {high:.3g} Hz for the length and "
                f"sample time of the log (got {wanted:g})"
            )
        return [wanted]
    if not within(0.0, low, high):
        fewest = int(np.ceil(PERIODS / SHARE))
        raise ValueError(
            f"must have at least {fewest} samples for an observer (got {len(log.place)}): "
            "record more, or replay with --open-loop"
        )
    slowest = min(high, max(low, BANDWIDTHS[-1]))
    return [hz for hz in BANDWIDTHS if within(low, hz, high)] or [slowest]
