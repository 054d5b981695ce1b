"""Linear programmes, solved by SciPy's HiGHS: inputs within bounds that keep errors small."""

from typing import Any, NamedTuple

import numpy as np
from scipy import sparse
from scipy.optimize import linprog

from hfc_design.core.numbers import Floats

#: Methods of HiGHS: interior points, and the dual simplex if they break off.
METHODS = "highs-ipm", "highs-ds"


class Linear(NamedTuple):
    """System ``x(k+1) = a(k) x(k) + b(k) u(k)`` from rest; one of the states is the output."""

    a: Floats  # (steps, states, states)
    b: Floats  # (steps, states, inputs)
    output: int  # index of the output among the states


class Solved(NamedTuple):
    """Solution of a linear programme."""

    inputs: Floats  # (steps, inputs)
    errors: Floats  # (steps,) that they leave
    multipliers: Floats  # (steps,) derivative of the least value by each error
    budget: float  # minus its derivative by the budget of the errors; 0 without a budget


class LinearProgram(NamedTuple):
    """Programme for small ``errors(k) - x(k)``, k = 1 ... steps; all is scaled to about 1."""

    shape: tuple[int, int, int]  # steps, states, inputs
    equal: sparse.csc_matrix  # columns: states, inputs, positive and negative parts of errors
    right: Floats
    bounds: Floats  # (columns, 2)
    size: Floats  # (states,) units of the states
    unit: Floats  # (inputs,) units of the inputs
    scale: float  # unit of the errors

    @property
    def magnitudes(self) -> Floats:
        """Row (columns,) that sums the magnitudes of the errors."""
        steps, states, inputs = self.shape
        return np.concatenate([np.zeros(steps * (states + inputs)), np.ones(2 * steps)])

    def least_sum(self) -> Solved | None:
        """Return the solution with the least sum of magnitudes; None: the solver found none."""
        return self._solved(self.magnitudes, self.scale)

    def least_state(self, state: int, step: int, sign: float, budget: float) -> Solved | None:
        """Return that with the least ``sign x(step)`` of a state, and errors within ``budget``."""
        cost = np.zeros(self.equal.shape[1])
        cost[(step - 1) * self.shape[1] + state] = sign
        return self._solved(cost, self.size[state], budget)

    def _solved(self, cost: Floats, size: float, budget: float | None = None) -> Solved | None:
        steps, states, inputs = self.shape
        more: Any = {}
        if budget is not None:
            more = {"A_ub": self.magnitudes[None], "b_ub": [budget / self.scale]}
        more |= {"A_eq": self.equal, "b_eq": self.right, "bounds": self.bounds}
        solution: Any = None
        for method in METHODS:
            solution = linprog(cost, **more | {"method": method})
            if solution.x is not None:
                break
        else:
            return None
        _, given, off = np.split(solution.x, [steps * states, steps * (states + inputs)])
        given, (above, below) = given.reshape(steps, inputs), off.reshape(2, steps)
        by_error = solution.eqlin.marginals[steps * states :] * size / self.scale
        by_budget = solution.ineqlin.marginals.sum() * size / self.scale
        errors = self.scale * (above - below)
        return Solved(given * self.unit, errors, by_error, -float(by_budget))


def linear_program(system: Linear, errors: Floats, low: Floats, high: Floats) -> LinearProgram:
    """Return the linear programme of bounded inputs that keep errors small.

    ``errors`` (steps,) are without inputs; the inputs are in ``low`` to ``high`` (steps, inputs).
    """
    steps, states, inputs = system.b.shape
    input_range = np.maximum(np.abs(low), np.abs(high)).max(axis=0)
    unit = np.where(input_range > 0.0, input_range, 1.0)
    size = _sizes(system, unit)
    scale = float(np.abs(errors).mean()) or 1.0
    rows, identity = steps * states, sparse.identity(steps)
    below = _blocks(system.a[1:] * size / size[:, None], states, (rows, rows))
    driven = _blocks(system.b * unit / size[:, None], 0, (rows, steps * inputs))
    output = np.eye(states)[[system.output]] * size[system.output] / scale
    chosen = sparse.kron(identity, output)
    free = sparse.identity(rows) - below
    equal = sparse.bmat([[free, -driven, None, None], [chosen, None, identity, -identity]])
    least = [np.full(rows, -np.inf), (low / unit).ravel(), np.zeros(2 * steps)]
    most = [np.full(rows, np.inf), (high / unit).ravel(), np.full(2 * steps, np.inf)]
    bounds = np.column_stack([np.concatenate(least), np.concatenate(most)])
    right = np.concatenate([np.zeros(rows), errors / scale])
    return LinearProgram(system.b.shape, equal.tocsc(), right, bounds, size, unit, scale)


def _sizes(system: Linear, unit: Floats) -> Floats:
    """Return the solver's unit of each state (states,): 1 % of the inputs' largest effect."""
    moved = system.b[0] * unit
    total = np.zeros(len(moved))
    for a in system.a:
        total += np.abs(moved).sum(axis=1)
        moved = a @ moved
    return np.where(total > 0.0, 0.01 * total, 1.0)


def _blocks(each: Floats, row: int, shape: tuple[int, int]) -> sparse.coo_matrix:
    """Return a matrix with blocks (count, rows, columns) on the diagonal that begins at ``row``."""
    count, rows, columns = each.shape
    step, down, right = np.ogrid[:count, :rows, :columns]
    i, j = np.broadcast_arrays(row + step * rows + down, step * columns + right)
    return sparse.coo_matrix((each.ravel(), (i.ravel(), j.ravel())), shape)
