"""The linear programmes, by SciPy's HiGHS: inputs within bounds that keep errors small."""

from typing import Any, NamedTuple

import numpy as np
from scipy import sparse
from scipy.optimize import linprog

from hfc_design.core.numbers import Floats

#: Methods of HiGHS: interior points, and the dual simplex if they break off.
METHODS = "highs-ipm", "highs-ds"


class Linear(NamedTuple):
    """``x(k+1) = a(k) x(k) + b(k) u(k)`` from rest, of which one state counts."""

    a: Floats  # (steps, states, states)
    b: Floats  # (steps, states, inputs)
    output: int  # the number of that state


class Solved(NamedTuple):
    """Solution of a linear programme."""

    inputs: Floats  # (steps, inputs)
    errors: Floats  # (steps,) that they leave
    multipliers: Floats  # (steps,) what the least value changes by with each error
    budget: float  # and less what it changes by with the budget of the errors, if there is one


class LinearProgram(NamedTuple):
    """``errors(k) - x(k)``, k = 1 ... steps, by inputs between bounds; all scaled to about 1."""

    shape: tuple[int, int, int]  # steps, states, inputs
    equal: sparse.csc_matrix  # states, inputs, errors above zero, errors below
    right: Floats
    bounds: Floats  # (columns, 2)
    size: Floats  # (states,) units of the states
    unit: Floats  # (inputs,) units of the inputs
    scale: float  # unit of the errors

    @property
    def magnitudes(self) -> Floats:
        """(columns,) the row that sums the errors' magnitudes."""
        steps, states, inputs = self.shape
        return np.concatenate([np.zeros(steps * (states + inputs)), np.ones(2 * steps)])

    def least_sum(self) -> Solved | None:
        """The least sum of magnitudes; None: the solver found no solution."""
        return self._solved(self.magnitudes, self.scale)

    def least_state(self, state: int, step: int, sign: float, budget: float) -> Solved | None:
        """The least ``sign x(step)`` of a state, with the sum of magnitudes limited by a budget."""
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
        scaled_inputs = solution.x[steps * states : steps * (states + inputs)].reshape(
            steps, inputs
        )
        above, below = solution.x[steps * (states + inputs) :].reshape(2, steps)
        by_error = solution.eqlin.marginals[steps * states :] * size / self.scale
        by_budget = solution.ineqlin.marginals.sum() * size / self.scale
        return Solved(
            scaled_inputs * self.unit, self.scale * (above - below), by_error, -float(by_budget)
        )


def linear_program(system: Linear, errors: Floats, low: Floats, high: Floats) -> LinearProgram:
    """Return the linear programme of bounded inputs that keep errors small.

    ``errors`` (steps,) are those without inputs; ``low`` and ``high`` (steps, inputs) bound these.
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
    """(states,) a hundredth of the inputs' largest effect on each state: the solver's unit."""
    moved = system.b[0] * unit
    total = np.zeros(len(moved))
    for a in system.a:
        total += np.abs(moved).sum(axis=1)
        moved = a @ moved
    return np.where(total > 0.0, 0.01 * total, 1.0)


def _blocks(each: Floats, row: int, shape: tuple[int, int]) -> sparse.coo_matrix:
    """Blocks (count, rows, columns) along the diagonal from a row and the first column on."""
    count, rows, columns = each.shape
    step, down, right = np.ogrid[:count, :rows, :columns]
    i, j = np.broadcast_arrays(row + step * rows + down, step * columns + right)
    return sparse.coo_matrix((each.ravel(), (i.ravel(), j.ravel())), shape)
