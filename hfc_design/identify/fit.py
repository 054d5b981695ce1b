"""Fit of a machine's parameters to a recording, with the observer that gives the least residual.

The fit is tried from many starts (sets of parameters), and the best of these are refined.
"""

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from typing import NamedTuple, TypeVar

import jax
import numpy as np
from scipy.signal import fftconvolve, lfilter
from scipy.stats import qmc

from hfc_design.core.numbers import Floats, Mask, Scalar, cores, within
from hfc_design.core.records import either
from hfc_design.identify.parameters import FACTOR, LOAD, OFFSETS, FreeParameters
from hfc_design.identify.recording import Recording
from hfc_design.identify.replay import DAMPED, Replay, Residual, replay

#: Number of starts that are simulated, and number of the best starts that are refined.
STARTS, REFINED = 100, 10
#: Starts lie within this factor of ``near``, or within so many scales for parameters of any sign.
AWAY = 5.0
#: Largest number of steps of Levenberg-Marquardt when a start is refined, and in the final fit.
#: Either ends at a step that reduces the sum of squares by less than ``LOOSE`` or ``TIGHT``.
FEW, MANY = 15, 100
LOOSE, TIGHT = 1e-3, 1e-8
#: Initial and largest damping; least weight of a number in the damping, as a share of the largest
#: weight, so that barely determined numbers do not diverge; slope beyond which squares overflow.
DAMPING, MOST, WEAK, STEEP = 1e-3, 1e3, 1e-3, 1e130
#: Most updates of the scales of the outputs; share by which a scale must change for another update.
ROUNDS, SETTLED = 5, 0.02
#: Number of steps in the search for the size of the load.
PUSHED = 3
#: Share by which the residual of a refined start may exceed the best one and still agree with it.
SAME = 0.01
#: A residual below this share of the motion counts as zero: in a log without noise only rounding
#: remains.
NOTHING = 1e-6
#: Prior standard deviation of a number about its start: so large that any information in a log
#: outweighs it. A number on which the log has no information stays at its start.
VAGUE = float(np.log(FACTOR))
#: Longest lag at which correlations of the residual count, as a share of the log. As by Newey and
#: West, their weights fall to 0 there.
CORRELATED = 0.02
#: Bandwidths of the observer that are tried [Hz]: none above ``SHARE`` times the sampling rate, and
#: none with fewer than ``PERIODS`` periods in the log, since up to three periods do not count.
BANDWIDTHS, SHARE, PERIODS = (50.0, 20.0, 5.0), 0.1, 10.0
#: Largest bandwidth that a user may request, in sampling rates; a faster observer does not settle.
LARGEST_SHARE = 0.2
#: A slower observer is tried if, with the parameters found so far, its residual is less than this
#: multiple of the faster observer's.
WORTH = 3.0
#: If the residual exceeds this share of that of the observer without a machine, slower observers
#: [Hz] are tried from all starts. This happens if a spring is soft, for example.
SPOILT, SLOWER = 0.4, (5.0, 2.0)
#: Start value of the lag [samples]; least lag that is accepted, in standard errors.
LAG, CLEAR = 0.5, 4.0

One = TypeVar("One")
Made = TypeVar("Made")
#: Function that is called with a line on the progress at every step.
Tell = Callable[[str], None]


def silent(line: str) -> None:
    """Ignore the line."""


class Problem(NamedTuple):
    """The residual that a fit minimises; problems of one kind and length share one program."""

    free: FreeParameters
    residual: Residual
    scale: Floats  # (outputs,) size of the residual, by which ``squares`` divides
    moves: Floats  # (names + 2,) 1 for numbers that the fit changes, 0 for those it keeps
    bandwidth: float | None  # of the observer [Hz]; 0: open loop; None: the closed loop

    def off(self, numbers: Scalar) -> Scalar:
        """Return the residual (steps, outputs) in units of the outputs, recorded less simulated."""
        return self.residual(*self.free.parts(numbers))

    def squares(self, off: Floats) -> float:
        """Return the sum of squares of a residual ``off`` (steps, outputs) divided by ``scale``."""
        with np.errstate(over="ignore", invalid="ignore"):  # a replay may diverge
            return float(np.sum(np.square(off / self.scale)))

    @property
    def observer(self) -> str:
        """Kind of replay of the recording, in words."""
        if self.bandwidth is None:
            return "closed loop"
        return f"observer of {self.bandwidth:g} Hz" if self.bandwidth else "open loop"


class Fit(NamedTuple):
    """Result of a fit; ``free`` gives the values that the numbers stand for."""

    problem: Problem
    numbers: Floats  # (names + 2,)
    residual: Floats  # (steps, outputs) recorded less simulated, 0 where it does not count
    jacobian: Floats  # (steps, outputs, names + 2) slopes of the residual by the numbers
    agreeing: int  # number of refined starts that ended with the same residual

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
        """Delay of the effect of the command after its samples in the log [samples]."""
        return float(self.numbers[-2])

    @property
    def lag(self) -> float:
        """Part of the delay that is a first-order lag [samples]."""
        return abs(float(self.numbers[-1]))


def rms(residual: Floats) -> Floats:
    """Return the root mean square (outputs,) of a residual (steps, outputs)."""
    return np.asarray(np.sqrt(np.mean(residual**2, axis=0)))


_off = jax.jit(Problem.off)


@jax.jit
def _both(problem: Problem, numbers: Scalar) -> Scalar:
    def twice(numbers: Scalar) -> tuple[Scalar, Scalar]:
        off = problem.off(numbers)
        return off, off

    return jax.jacfwd(twice, has_aux=True)(numbers)


def residuals(problem: Problem, numbers: Floats) -> Floats:
    """Return ``Problem.off``, computed in float64."""
    with jax.enable_x64(True):
        return np.asarray(_off(problem, numbers))


def slopes(problem: Problem, numbers: Floats) -> tuple[Floats, Floats]:
    """Return ``Problem.off`` and its slopes (steps, outputs, names + 2); 0 for numbers kept."""
    with jax.enable_x64(True):
        jacobian, off = _both(problem, numbers)
    return np.asarray(off), np.asarray(jacobian) * problem.moves


def side_by_side(one: Callable[[One], Made], many: Iterable[One]) -> list[Made]:
    """Return ``one(item)`` for each item, in threads on all cores: a replay releases the GIL."""
    with ThreadPoolExecutor(cores()) as pool:
        return [*pool.map(one, many)]


def levenberg_marquardt(
    problem: Problem, numbers: Floats, enough: float, steps: int
) -> tuple[Floats, float]:
    """Return the numbers (names + 2,) where Levenberg-Marquardt ends, and squares with the prior.

    It ends after ``steps``, or if a step reduces the squares by only the share ``enough``. Damping
    as by Nielsen (Damping parameter in Marquardt's method, IMM-REP-1999-05, 1999).
    """
    moving = np.flatnonzero(problem.moves)
    begun = np.asarray(problem.free.begun)[moving]

    def all_of(off: Floats, numbers: Floats) -> float:
        return problem.squares(off) + float(np.sum(np.square((numbers[moving] - begun) / VAGUE)))

    (off, jacobian), damping, growth = slopes(problem, numbers), DAMPING, 2.0
    least, normal = all_of(off, numbers), np.zeros((0, 0))
    for _ in range(steps if np.abs(jacobian).max() < STEEP and np.isfinite(least) else 0):
        if not normal.size:  # no step from these numbers was tried yet
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
    """Return the problem with a scale of its constant load, and numbers (names + 2,) to start from.

    The scale is the load that moves the axis as far as the rms of ``command`` (steps,) does. The
    start is the load that balances the mean of the command, since this is close to the true load.
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
    """Return the numbers of the best refined start, and how many refined starts agree with it.

    The first start is ``near`` (names + 2,); a Sobol sequence draws the other starts around it.
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
    close = problem._replace(scale=scale)  # gives the prior about ``begun`` its weight
    ended = side_by_side(lambda one: levenberg_marquardt(close, one, LOOSE, FEW), best)
    squares = np.array([least for _, least in ended]) * first.min() / count
    root = np.sqrt(squares / count)
    agree = root <= max((1.0 + SAME) * root.min(), NOTHING)
    return ended[int(root.argmin())][0], int(agree.sum())


def settled(problem: Problem, numbers: Floats, agreeing: int = 0, tell: Tell = silent) -> Fit:
    """Return the fit that starts at ``numbers``; the scale of an output is its rms residual."""
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
    """Return a ``Fit`` with these ``numbers``, and residual and slopes there, without fitting."""
    return Fit(problem, numbers, *slopes(problem, numbers), agreeing)


def refitted(fit: Fit, numbers: Floats, moving: Mask) -> Fit:
    """Return a fit from ``numbers`` (names + 2,) that changes only parameters ``moving`` (names,).

    Delay and lag (``LATE``) are changed if ``fit`` changed them.
    """
    moves = np.append(moving.astype(float), fit.problem.moves[-2:])
    return settled(fit.problem._replace(moves=moves), numbers, fit.agreeing)


def covariance_of(fit: Fit) -> tuple[Floats, Floats]:
    """Return the covariance (numbers, numbers), and each variance over that for white noise.

    It is computed in the singular directions of the slopes. There no slope is lost beside a far
    larger one, as it would be in the normal matrix, and no variance becomes negative.
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
    """Return slopes (steps x outputs, numbers) of residuals that are divided by their ``scale``."""
    return np.asarray((slopes / scale[:, None]).reshape(-1, slopes.shape[-1]))


def _correlated(residual: Floats, slopes: Floats) -> Floats:
    """Return the covariance of slopes.T @ noise (numbers,) for noise correlated as the residual."""
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
    """Return the fit from many starts, or if ``near`` from one; in a closed loop without delay."""
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
    """Return the fit under the recorded command, with the observer of the least residual.

    ``tried`` are the ``bandwidths`` of the observers [Hz], the fastest first. ``near``: the machine
    is known to be near the first start, so the fastest observer is not fitted from other starts.
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
            break  # only rounding would decide which observer has the smaller residual
        again = settled(problem, best.numbers, best.agreeing, tell)
        if again.rms[0] < best.rms[0]:  # of the position
            best = again
    for hz in SLOWER if others else ():
        if unexplained(best, log) > SPOILT and hz * log.duration >= PERIODS:
            slow = by_starts(free, log, replay(free, log, hz, substeps), hz, seed, tell)
            best = min(best, slow, key=partial(unexplained, log=log))
    return _with_lag(best)


def unexplained(fit: Fit, log: Recording) -> float:
    """Return the rms residual of the position over that of the observer without a machine."""
    w = 2.0 * np.pi * (fit.problem.bandwidth or 0.0) * log.sample_time
    poles = [1.0, 2.0 * DAMPED * w - 2.0, 1.0 - 2.0 * DAMPED * w + w * w]
    alone = lfilter([1.0, -2.0, 1.0], poles, log.place - log.place[0])
    return float(fit.rms[0] / max(np.sqrt(np.mean(alone**2)), 1e-300))


def _with_lag(fit: Fit) -> Fit:
    """Return a fit in which part of the delay is a lag, if the log shows it; otherwise ``fit``."""
    moves = fit.problem.moves.copy()
    if not (fit.free.sought[1] and moves[-2]) or fit.lag:
        return fit
    moves[-1] = 1.0
    problem = fit.problem._replace(moves=moves)
    again = settled(problem, np.append(fit.numbers[:-1], LAG), fit.agreeing)
    error = np.sqrt(covariance_of(again)[0][-1, -1])
    return again if again.lag > CLEAR * error and again.rms[0] < fit.rms[0] else fit


def bandwidths(log: Recording, wanted: float | None) -> list[float]:
    """Return the bandwidths of the observer to try [Hz], the fastest first; or only ``wanted``.

    Raises:
        ValueError: the log is too short for any observer; or ``wanted`` is too low or too high.
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
