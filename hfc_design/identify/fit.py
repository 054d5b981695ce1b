"""Parameters under which a machine does what was recorded: many starts, the best ones refined."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import lineax as lx
import numpy as np
import optimistix as optx
from scipy.stats import qmc

from hfc_design.core.numbers import Floats, Scalar
from hfc_design.identify.free import FACTOR, Free
from hfc_design.identify.replay import Residual

#: Starts that are simulated side by side, and how many of the best are refined.
STARTS, REFINED = 100, 10
#: Where they are drawn: up to so many times the value or its inverse.
AWAY = 5.0
#: Steps of Levenberg-Marquardt that a refined start has, and the last one.
FEW, MANY = 15, 200
#: Its relative and absolute tolerances in both.
LOOSE, TIGHT = (1e-3, 1e-4), (1e-7, 1e-8)
#: The scales are taken anew at most so many times, until none changes by this share.
ROUNDS, SETTLED = 5, 0.02
#: Refined starts that end this near the best one, relative, have found the same.
SAME = 0.01
#: A residual below such a share of the motion is none: of a log without noise all that is left is
#: rounding.
NOTHING = 1e-6
#: How sure it is beforehand that a number is where it began, as a standard deviation. So little
#: that a log that tells anything of it overrules it; what it does not tell stays where it began.
VAGUE = float(np.log(FACTOR))


class Fit(NamedTuple):
    """What was found; numbers are those of ``free``, the last one the delay."""

    free: Free
    numbers: Floats  # (names + 1,)
    residual: Floats  # (steps, outputs) recorded less simulated, 0 where it does not count
    jacobian: Floats  # (steps, outputs, names + 1) of the residual
    scale: Floats  # (outputs,) rms of the residual, which weighs each
    agreeing: int  # refined starts that ended with the same residual

    @property
    def rms(self) -> Floats:
        """(outputs,) root mean square of the residual [unit of the output]."""
        return np.asarray(np.sqrt(np.mean(self.residual**2, axis=0)))

    @property
    def late(self) -> float:
        """By how many samples the command acts later than it was recorded."""
        return float(self.numbers[-1])


class Problem(NamedTuple):
    """A residual and what its outputs weigh; one program does for all of a kind and a length."""

    free: Free
    residual: Residual
    scale: Floats  # (outputs,)
    held: Floats  # (names + 1,) 0 where a number stays as it is, else 1

    def off(self, numbers: Scalar) -> Scalar:
        """(steps, outputs) in units of the outputs."""
        return self.residual(self.free.parameters(numbers), numbers[-1])

    def cost(self, numbers: Scalar) -> Scalar:
        """Mean of the squares, each output in its own scale."""
        return jnp.mean(jnp.square(self.off(numbers) / self.scale))

    def refined(
        self, numbers: Scalar, tolerance: tuple[float, float], steps: int, certain: float = 0.0
    ) -> Scalar:
        """Where Levenberg-Marquardt ends (names + 1,).

        ``certain`` is 1 / ``VAGUE`` where the scale is that of the residual, and else 0.
        """
        begun, held = self.free.begun, self.held

        def weighed(moved: Scalar, _: Any) -> Scalar:
            now = jnp.where(held > 0.0, moved, numbers)
            off = self.off(now) / self.scale
            # A fit that ran away is worse than every other and has no slope.
            off = jnp.where(jnp.isfinite(off), off, 1e6)
            both = jnp.concatenate([off.ravel(), certain * (now - begun)])
            return both / jnp.sqrt(off.size)

        # Many rows, few numbers, damped: the normal matrix is as good, a hundred times as fast.
        solver: Any = optx.LevenbergMarquardt(*tolerance, linear_solver=lx.Normal(lx.Cholesky()))
        solve: Any = optx.least_squares
        options = {"jac": "fwd"}  # few parameters, many samples
        return solve(weighed, solver, numbers, options=options, max_steps=steps, throw=False).value


@jax.jit
def offs(problem: Problem, numbers: Scalar) -> Scalar:
    """``Problem.off``."""
    return problem.off(numbers)


@jax.jit
def costs(problem: Problem, numbers: Scalar) -> Scalar:
    """(starts,) ``Problem.cost`` of numbers (starts, names + 1)."""
    return jax.vmap(problem.cost)(numbers)


@jax.jit
def _slopes(problem: Problem, numbers: Scalar) -> Scalar:
    return jax.jacfwd(problem.off)(numbers)


@jax.jit
def _nearly(problem: Problem, numbers: Scalar) -> Scalar:
    return jax.vmap(lambda x: problem.refined(x, LOOSE, FEW))(numbers)


@jax.jit
def _wholly(problem: Problem, numbers: Scalar) -> Scalar:
    return problem.refined(numbers, TIGHT, MANY, 1.0 / VAGUE)


def searched(problem: Problem, seed: int) -> tuple[Floats, int]:
    """Numbers of the best of many starts, and how many of those refined ended like it.

    The first start is that of ``free``; the others are drawn by a Sobol sequence.
    """
    starts = _starts(problem.free, seed)
    held = np.where(problem.held > 0, starts, starts[0])
    first = np.asarray(costs(problem, held))
    if not np.isfinite(first).any():
        return starts[0], 0
    best = held[np.argsort(np.where(np.isfinite(first), first, np.inf))[:REFINED]]
    near = problem._replace(scale=np.sqrt(np.nanmin(first)) * problem.scale)
    ended = np.asarray(_nearly(near, best))
    found = np.sqrt(np.asarray(costs(problem, ended)))
    found = np.where(np.isfinite(found), found, np.inf)
    return ended[found.argmin()], int((found <= max((1.0 + SAME) * found.min(), NOTHING)).sum())


def settled(problem: Problem, numbers: Floats) -> tuple[Problem, Floats]:
    """The problem with each output in the scale of its residual, and the numbers it ends at."""
    scale = np.asarray(problem.scale)
    for k in range(ROUNDS):
        rms = np.sqrt(np.mean(np.asarray(offs(problem, numbers)) ** 2, axis=0))
        now = np.maximum(rms, 1e-9 * np.asarray(problem.scale))
        if k and (np.abs(np.log(now / scale)) < SETTLED).all():
            break
        scale, numbers = now, np.asarray(_wholly(problem._replace(scale=now), numbers))
    return problem._replace(scale=scale), numbers


def fitted(problem: Problem, numbers: Floats, agreeing: int) -> Fit:
    """The fit at ``numbers``, with its residual and slopes."""
    residual = np.asarray(offs(problem, numbers))
    jacobian = np.asarray(_slopes(problem, numbers)) * problem.held
    return Fit(problem.free, numbers, residual, jacobian, problem.scale, agreeing)


def _starts(free: Free, seed: int) -> Floats:
    """(starts, names + 1) within ``AWAY`` of the first one, which is the own one."""
    dimensions = len(free.names)
    drawn = 2.0 * qmc.Sobol(dimensions, rng=np.random.default_rng(seed)).random(128) - 1.0
    width = np.where(free.positive > 0, np.log(AWAY), AWAY)
    others = np.hstack([width * drawn[: STARTS - 1], np.zeros((STARTS - 1, 1))])
    return np.vstack([free.begun, free.begun + others])
