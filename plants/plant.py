"""What a plant is."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, eq=False)  # compared by identity: a plant is a key of compiled code
class Plant:
    """A drive as data and pure functions of scalars.

    The closed loop calls them for one machine at a time; ``jax.vmap`` makes the population::

        fixed = plant.coefficients(parameters)
        state = plant.initial_state(zero)
        state = plant.step(fixed, state, command, loads, dt)
        readings = plant.signals(fixed, state)

    ``loads`` are the load at the start, the middle and the end of the step, because a
    fourth-order integrator asks for all three.
    """

    name: str
    #: Record class of the physical parameters; its defaults are the nominal machine.
    parameters: type[Any]
    #: What is wrong with a dict of changed parameters, in one line; None if nothing is.
    fault: Callable[[dict[str, float]], str | None]
    #: Unit of each signal, for messages and plots.
    units: dict[str, str]
    #: Speed [of the position, per s] up to which an integration step of some length is stable.
    fastest: Callable[[Any, float], float]
    coefficients: Callable[[Any], Any]
    initial_state: Callable[[Any], Any]
    step: Callable[[Any, Any, Any, tuple[Any, Any, Any], Any], Any]
    #: Everything that a controller may read besides the tracking error and its rate.
    signals: Callable[[Any, Any], dict[str, Any]]
    #: State field that is to follow the reference, and the field of its rate.
    position: str
    velocity: str
    #: Each angle that an encoder reads, with the state field of its rate.
    encoders: dict[str, str]
