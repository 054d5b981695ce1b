"""Fit of a machine's parameters to a recording, with the observer that gives the least residual.

Many starts, of which the best are refined.
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
from hfc_design.core.records import either
from hfc_design.identify.parameters import FACTOR, LOAD, OFFSETS, FreeParameters
from hfc_design.identify.recording import Recording
from hfc_design.identify.replay import DAMPED, Replay, Residual, replay

#: Starts that are simulated side by side, and number of the best that are refined.
STARTS, REFINED = 100, 10
#: Range of the starts: up to so many times the value or its inverse.
AWAY = 5.0
#: Largest number of replays of Levenberg-Marquardt for a refined start, and for the final fit;
#: share by which the next replay must reduce the sum of squares in each.
FEW, MANY = 15, 100
LOOSE, TIGHT = 1e-3, 1e-8
#: Initial and largest damping; its least weight, as a share of that of the steepest slope, which
#: keeps barely determined numbers from diverging; largest slope, beyond which squares overflow.
DAMPING, MOST, WEAK, STEEP = 1e-3, 1e3, 1e-3, 1e130
#: The scales are updated at most so many times, until none changes by this share.
ROUNDS, SETTLED = 5, 0.02
#: Number of steps in the search for the size of the load.
PUSHED = 3
#: Relative distance from the best up to which refined starts count as the same result.
SAME = 0.01
#: A residual below this share of the motion counts as zero: for a log without noise only rounding
#: remains.
NOTHING = 1e-6
#: Prior standard deviation of a number about its start. So large that any information in a log
#: outweighs it; a number without information stays at its start.
VAGUE = float(np.log(FACTOR))
#: Correlations of the residual are counted up to this share of the log, as by Newey and West with
#: weights that fall to 0.
CORRELATED = 0.02
#: Bandwidths of the observer that are tried [Hz], none faster than this share of the samples and
#: none slower than so many periods in the log, since the first three periods are left out.
BANDWIDTHS, SHARE, PERIODS = (50.0, 20.0, 5.0), 0.1, 10.0
#: Largest requested bandwidth as a share of the samples; a faster observer does not settle.
LARGEST_SHARE = 0.2
#: A slower observer is tried if, with the parameters found so far, its residual is less than this
#: multiple of that of the faster one.
WORTH = 3.0
#: Residual, as a share of that of the observer alone, from which on slower observers [Hz] are
#: tried from all starts; a soft spring is a case.
SPOILT, SLOWER = 0.4, (5.0, 2.0)
#: First lag of the search [samples], and least length of an accepted one in standard errors.
LAG, CLEAR = 0.5, 4.0

One = TypeVar("One")
Made = TypeVar("Made")
#: Function that is called with a line at every step.
Tell = Callable[[str], None]


def silent(line: str) -> None:
    """Ignore the line."""


class Problem(NamedTuple):
    """A residual with the weights of its outputs; all of a kind and a length share one program."""

    free: FreeParameters
    residual: Residual
    scale: Floats  # (outputs,)
    moves: Floats  # (names + 2,) 0 where a number stays as it is, else 1
    bandwidth: float | None  # of the observer [Hz]; 0: open loop; None: the closed loop

    def off(self, numbers: Scalar) -> Scalar:
        """(steps, outputs) residual in units of the outputs."""
        return self.residual(*self.free.parts(numbers))

    def squares(self, off: Floats) -> float:
        """Sum of the squares of the residual ``off``, each output in its own scale."""
        with np.errstate(over="ignore", invalid="ignore"):  # a replay may run away
            return float(np.sum(np.square(off / self.scale)))

    @property
    def observer(self) -> str:
        """Kind of replay of the recording, in words."""
        if self.bandwidth is None:
            return "closed loop"
        return f"observer of {self.bandwidth:g} Hz" if self.bandwidth else "open loop"


class Fit(NamedTuple):
    """Result of a fit; its numbers are those of ``free``."""

    problem: Problem
    numbers: Floats  # (names + 2,)
    residual: Floats  # (steps, outputs) recorded less simulated, 0 where it does not count
    jacobian: Floats  # (steps, outputs, names + 2) of the residual
    agreeing: int  # refined starts that ended with the same residual

    @property
    def free(self) -> FreeParameters:
        """The fitted parameters."""
        return self.problem.free

    @property
    def how(self) -> str:
        """Kind of replay of a log, in words."""
        command = "" if self.problem.bandwidth is None else "recorded command, "
        return command + self.problem.observer

    @property
    def rms(self) -> Floats:
        """(outputs,) root mean square of the residual [unit of the output]."""
        return rms(self.residual)

    @property
    def values(self) -> Floats:
        """(names,) fitted values, in units of the drive."""
        return np.asarray(self.free.values(self.numbers))

    @property
    def late(self) -> float:
        """Delay of the command relative to its record [samples]."""
        return float(self.numbers[-2])

    @property
    def lag(self) -> float:
        """Part of the delay that is a first-order lag [samples]."""
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
    """``Problem.off``, and its slopes (steps, outputs, names + 2) in the directions that move."""
    with jax.enable_x64(True):
        jacobian, off = _both(problem, numbers)
    return np.asarray(off), np.asarray(jacobian) * problem.moves


def side_by_side(one: Callable[[One], Made], many: Iterable[One]) -> list[Made]:
    """Results of ``one`` for each item, on all cores: a replay releases Python's lock."""
    with ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        return [*pool.map(one, many)]


def levenberg_marquardt(
    problem: Problem, numbers: Floats, enough: float, steps: int
) -> tuple[Floats, float]:
    """End of Levenberg-Marquardt (names + 2,), and the squares there.

    It ends when a step reduces the squares by a share of ``enough`` only, or is predicted to. The
    damping is that of Nielsen (Damping parameter in Marquardt's method, IMM-REP-1999-05, 1999).
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
    """The problem with a constant load scaled by the effect of a ``command`` (steps,).

    The load that balances the mean of the command is close to the true one: the returned numbers
    (names + 2,) are the start of a search.
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
    """Numbers of the best of many starts, and the count of refined starts that end like it.

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
    """The fit that starts at ``numbers``, with each output in the scale of its residual."""
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
    """Fit again from ``numbers`` (names + 2,), of which only ``moving`` (names,) are changed.

    Those of ``LATE`` are changed if they were before.
    """
    moves = np.append(moving.astype(float), fit.problem.moves[-2:])
    return settled(fit.problem._replace(moves=moves), numbers, fit.agreeing)


def covariance_of(fit: Fit) -> tuple[Floats, Floats]:
    """(numbers, numbers) covariance; ratio of each number's variance to that under white noise.

    It is computed in the slopes' singular directions: none is lost beside a far larger one, as it
    would be in the normal matrix, and the result is a square.
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
    """(steps outputs, numbers) slopes of residuals scaled to a deviation of 1."""
    return np.asarray((slopes / scale[:, None]).reshape(-1, slopes.shape[-1]))


def _correlated(residual: Floats, slopes: Floats) -> Floats:
    """(numbers, numbers) variance of the slopes times noise correlated like the residual."""
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
    """Fit from many starts, or from one that is ``near``; with a delay except in a closed loop."""
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
    """Fit under the recorded command, with the observer of the least residual.

    ``tried`` are the ``bandwidths`` of the observers. ``near``: the machine is known to be near the
    first start, and no others are tried.
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
    """Residual of the position, relative to that of the observer without a machine."""
    w = 2.0 * np.pi * (fit.problem.bandwidth or 0.0) * log.sample_time
    poles = [1.0, 2.0 * DAMPED * w - 2.0, 1.0 - 2.0 * DAMPED * w + w * w]
    alone = lfilter([1.0, -2.0, 1.0], poles, log.place - log.place[0])
    return float(fit.rms[0] / max(np.sqrt(np.mean(alone**2)), 1e-300))


def _with_lag(fit: Fit) -> Fit:
    """The fit with part of the delay as a lag, if the log distinguishes them."""
    moves = fit.problem.moves.copy()
    if not (fit.free.sought[1] and moves[-2]) or fit.lag:
        return fit
    moves[-1] = 1.0
    problem = fit.problem._replace(moves=moves)
    again = settled(problem, np.append(fit.numbers[:-1], LAG), fit.agreeing)
    error = np.sqrt(covariance_of(again)[0][-1, -1])
    return again if again.lag > CLEAR * error and again.rms[0] < fit.rms[0] else fit


def bandwidths(log: Recording, wanted: float | None) -> list[float]:
    """Bandwidths of the observers to try [Hz], the fastest first; or only the ``wanted`` one.

    Raises:
        ValueError: the log is too short for an observer, or for this one, or too slow.
    """
    low, share = PERIODS / log.duration, SHARE if wanted is None else LARGEST_SHARE
    high = share / log.sample_time
    if wanted is not None:
        if wanted and not within(low, wanted, high):
            raise ValueError(
                f"the bandwidth of the observer must be {low:.3g} to {high:.3g} Hz for the "
                f"length and sample time of the log (got {wanted:g})"
            )
        return [wanted]
    if not within(0.0, low, high):
        fewest = int(np.ceil(PERIODS / SHARE))
        raise ValueError(
            f"must have at least {fewest} samples for an observer (got {len(log.place)}): "
            f"record more, or replay with {either('--open-loop', 'bandwidth=0')}"
        )
    slowest = min(high, max(low, BANDWIDTHS[-1]))
    return [hz for hz in BANDWIDTHS if within(low, hz, high)] or [slowest]
