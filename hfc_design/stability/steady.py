"""Steady motions of machines by Newton's method: the operating points of all linear models.

In a steady motion, all moving quantities are shifted by the same distance from sample to sample.
The commands are those that the machine needs. A *lane* is one machine in one steady motion. Never
imports JAX.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from hfc_design.core.numbers import Floats, Mask

#: Newton's method: most steps, relative change that ends it, and one that is still accepted.
TRIES, SETTLED, NEAR = 30, 1e-9, 1e-5
#: A balanced matrix with a smaller determinant may be singular; smallest singular value of one, as
#: a share of the largest, that does not count as 0.
SINGULAR, RANK = 1e-7, 1e-11
#: Numbers with a smaller relative difference differ by rounding only.
ROUNDED = 1e-13
#: Factors on the speeds of motions sought first if none is found at the speeds themselves.
FAST = (1e3, 1e6, 1e9)


class Near(NamedTuple):
    """Machines linearised at given states and commands; the first axis of every array: lanes.

    If a machine moves, ``a`` is without the effect of position-dependent forces such as cogging,
    which is 0 in the mean of the travel.
    """

    a: Floats  # (states, states)
    b: Floats  # (states, axes)
    errors: Floats  # (axes, states) slopes of the errors
    along: Floats  # (states, axes) change of the states over a unit of travel of an axis
    changed: Floats  # () largest share of a step that depends on the place; 0: none does
    value: Floats
    slopes: Floats
    more: Any

    def needed(self, a: Floats, b: Floats, change: Floats) -> Floats:
        """Return states and commands (lanes, states + axes) for a ``change`` in a step.

        That of the states (lanes, states) is ``(a - 1) x + b u``; that of the errors may follow.
        """
        lanes, size, axes = b.shape
        below = [self.errors, np.zeros((lanes, axes, axes))]
        right = np.zeros((lanes, size + axes))
        right[:, : change.shape[1]] = change
        matrix = np.nan_to_num(np.block([[a - np.eye(size), b], below]))
        some = np.append(observable(self.slopes[..., :size]), np.ones(axes, bool))
        solution = np.zeros_like(right)
        solution[:, some] = solved(matrix[:, some][:, :, some], np.nan_to_num(right)[:, some])
        return solution


class SteadyMotions(NamedTuple):
    """Machines without a controller, one a lane, that are to move steadily at ``speeds``."""

    #: States and commands (lanes, states + axes) -> values, their slopes by these and by other
    #: inputs, and anything else. The values are states after a step, errors of all axes, others.
    step: Callable[[Floats], tuple[Floats, Floats, Any]]
    #: Factor on the speeds -> first states and commands.
    begun: Callable[[float], Floats]
    every: float  # time of a step [s]
    speeds: Floats  # (lanes, axes)

    def found(self) -> tuple[Floats, Near, Mask]:
        """Return states and commands, machines linearised there, and which motions exist."""
        size = -self.speeds.shape[1]
        first = self.begun(1.0)
        x, exists = self._followed(first, 1.0)
        for factor in FAST:  # parts behind a gap do not touch; braking at high speed closes it
            if exists.all():
                break
            begun = self.begun(factor)
            fast, _ = self._followed(begun, factor)
            fast[:, :size] += (first - begun)[:, :size]
            again, exists_again = self._followed(np.nan_to_num(fast), 1.0)
            x, exists = np.where(exists[:, None], x, again), exists | exists_again
        return x, self.near(x), exists

    def near(self, x: Floats) -> Near:
        """Return the machines linearised at states and commands ``x``."""
        value, slopes, more = self.step(x)
        value, slopes = np.array(value), np.array(slopes)
        axes = self.speeds.shape[1]
        size = x.shape[1] - axes
        # The slope of a distance is nan at 0, where it grows in both directions.
        slopes[:, size:] = np.nan_to_num(slopes[:, size:])
        a, b = slopes[:, :size, :size], slopes[:, :size, size : size + axes]
        errors = slopes[:, size : size + axes, :size]
        along = travel(a, errors)
        off, sizes = a @ along - along, np.abs(a) @ np.abs(along)
        off[np.abs(off) <= ROUNDED * sizes] = 0.0
        off[~self.speeds.any(axis=1)] = 0.0
        with np.errstate(all="ignore"):
            changed = np.nan_to_num(np.abs(off) / sizes).max(axis=(1, 2), initial=0.0)
        return Near(a + off @ errors, b, errors, along, changed, value, slopes, more)

    def _followed(self, x: Floats, factor: float) -> tuple[Floats, Mask]:
        """Return states and commands by Newton's method from ``x``, and whether they are steady."""
        size, far = x.shape[1] - self.speeds.shape[1], np.full(len(x), np.inf)
        for _ in range(TRIES):
            one = self.near(x)
            ahead = (one.along @ (self.every * factor * self.speeds)[..., None])[..., 0]
            off = one.value[:, : x.shape[1]].copy()
            off[:, :size] -= x[:, :size] + ahead
            sizes = np.abs(one.slopes[:, :size, : x.shape[1]]) @ np.abs(x)[..., None]
            still = np.abs(off[:, :size]) <= NEAR * (sizes[..., 0] + np.abs(x[:, :size]))
            move = one.needed(one.a, one.b, -off)
            x, before = x + move, far
            far = np.abs(move).max(axis=1) / np.maximum(np.abs(x).max(axis=1), 1e-300)
            # If a machine is stiff, or far away, rounding keeps the change above SETTLED.
            if ((far <= SETTLED) | (before <= far) & (far <= NEAR)).all():
                break
        # Least squares also end where no command has an effect, in a state that still changes.
        heard = observable(one.slopes[..., :size])
        sound = np.isfinite(one.slopes).all(axis=(1, 2)) & still[:, heard].all(axis=1)
        return x, (far <= NEAR) & sound


def travel(a: Floats, errors: Floats) -> Floats:
    """Return ``Near.along``, the change of states by a unit of travel that a step alters least."""
    lanes, size, axes = *a.shape[:2], errors.shape[1]
    ends = np.concatenate([np.zeros((size, axes)), -np.eye(axes)])
    whole = np.nan_to_num(np.concatenate([a - np.eye(size), errors], axis=1))
    solutions = [solved(whole, np.tile(end, (lanes, 1))) for end in ends.T]
    return np.stack(solutions, axis=2)


def observable(slopes: Floats) -> Mask:
    """Return which states (states,) change another value than a state, now or later.

    Other states, such as a count of samples, may change by themselves and are no part of a loop.
    """
    size, hears = slopes.shape[2], (slopes != 0.0).any(axis=0)
    seen = hears[size:].any(axis=0)
    for _ in range(size):
        seen = seen | hears[:size][seen].any(axis=0)
    return np.asarray(seen)


def solved(matrix: Floats, right: Floats) -> Floats:
    """Return least-squares solutions (lanes, n) of ``matrix x = right``, in balanced units."""
    rows, columns = np.ones(matrix.shape[:2]), np.ones(matrix.shape[::2])
    for _ in range(3):
        for axis in (2, 1):
            largest = np.abs(rows[:, :, None] * matrix * columns[:, None]).max(axis=axis)
            size = np.sqrt(np.where(largest > 0.0, largest, 1.0))
            rows, columns = (rows / size, columns) if axis == 2 else (rows, columns / size)
    even, scaled_right = rows[:, :, None] * matrix * columns[:, None], rows * right
    solution, open_ = np.zeros(columns.shape), scaled_right.any(axis=1)
    if matrix.shape[1] == matrix.shape[2]:
        regular = open_ & (np.abs(np.linalg.det(even)) > SINGULAR)
        solution[regular] = np.linalg.solve(even[regular], scaled_right[regular, :, None])[..., 0]
        open_ &= ~regular
    for k in np.flatnonzero(open_):
        solution[k] = np.linalg.lstsq(even[k], scaled_right[k], rcond=RANK)[0]
    solution[np.abs(solution) <= ROUNDED * np.abs(solution).max(axis=1, initial=0.0)[:, None]] = 0.0
    return np.asarray(columns * solution)
