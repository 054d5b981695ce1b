"""Fixed-step integration of a record of scalars."""

from collections.abc import Callable
from typing import TypeVar

from plants.drive import Loads, Scalar

State = TypeVar("State", bound=tuple[Scalar, ...])


def rk4(
    derivative: Callable[[State, Scalar], State], state: State, loads: Loads, dt: Scalar
) -> State:
    """One classical fourth-order Runge-Kutta step of length ``dt`` [s].

    ``derivative(state, load)`` returns the rates in a record of the same type; ``loads`` are
    the load at the start, the middle and the end of the step. The state is a NamedTuple of
    scalars, so that the compiler sees one flat expression.
    """

    def moved(rates: State, time: Scalar) -> State:
        return type(state)(*(x + time * rate for x, rate in zip(state, rates, strict=True)))

    start, middle, end = loads
    k1 = derivative(state, start)
    k2 = derivative(moved(k1, 0.5 * dt), middle)
    k3 = derivative(moved(k2, 0.5 * dt), middle)
    k4 = derivative(moved(k3, dt), end)
    total = (a + 2.0 * b + 2.0 * c + d for a, b, c, d in zip(k1, k2, k3, k4, strict=True))
    return moved(type(state)(*total), dt / 6.0)
