"""The plant integrated by diffrax sample by sample; the controller is that of einsum_peer.py.

The solver is the evaluator's own classical Runge-Kutta method, one step a sample, given to
diffrax as a Butcher tableau: so both compute the same numbers with the same four evaluations of
the derivative. Of diffrax's own solvers only Heun, of second order, was faster, by a fifth at
256 individuals; Tsit5 and Bosh3 were slower. ``ForwardMode`` and a single allowed step are its
cheapest settings.
"""

from collections.abc import Callable
from typing import Any

import diffrax
import einsum_peer
import jax
import numpy as np
from work import Machine, Work


class RungeKutta4(diffrax.AbstractERK):
    """The classical method; without an error estimate, because the step is fixed."""

    tableau = diffrax.ButcherTableau(
        c=np.array([0.5, 0.5, 1.0]),
        a_lower=(np.array([0.5]), np.array([0.0, 0.5]), np.array([0.0, 0.0, 1.0])),
        b_sol=np.array([1.0, 2.0, 2.0, 1.0]) / 6.0,
        b_error=np.zeros(4),
    )
    interpolation_cls = diffrax.ThirdOrderHermitePolynomialInterpolation.from_k

    def order(self, terms: Any) -> int:
        """Order of convergence."""
        return 4


def move(m: Machine, x: jax.Array, voltage: Any, loads: jax.Array, dt: float) -> jax.Array:
    """The state (6,) ``dt`` [s] later; the load [N m] is taken as linear in between."""

    def rates(time: Any, x: jax.Array, arguments: Any) -> jax.Array:
        voltage, load, change = arguments
        return einsum_peer.derivative(m, x, voltage, load + time / dt * change)

    solution = diffrax.diffeqsolve(
        diffrax.ODETerm(rates),
        RungeKutta4(),
        t0=0.0,
        t1=dt,
        dt0=dt,
        y0=x,
        args=(voltage, loads[0], loads[2] - loads[0]),
        saveat=diffrax.SaveAt(t1=True),
        adjoint=diffrax.ForwardMode(),
        max_steps=1,
        throw=False,
    )
    return solution.ys[0]


def prepare(work: Work) -> Callable[[], np.ndarray]:
    """A function that scores all individuals, (individuals,)."""
    return einsum_peer.prepare(work, move)
