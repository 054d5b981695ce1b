"""What a plant is."""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from typing import Any


def _unlimited(parameters: Any, dt: float) -> float:
    return inf


def _same(fixed: Any, value: Any) -> Any:
    return value


def _as_it_is(value: Any) -> Any:
    return value


#: What a command and a load with a unit are called; others are just "command" and "load".
COMMANDS = {"V": "voltage", "A": "current", "N m": "torque"}
LOADS = {"N m": "load_torque", "N": "force"}


def in_a_name(unit: str) -> str:
    """``unit`` as it ends the name of a column or of a metric: rad/s as rad_s, N m as Nm."""
    return unit.replace(" ", "").replace("/", "_")


@dataclass(frozen=True, eq=False)  # compared by identity: a plant is a key of compiled code
class Plant:
    """A drive as data and pure functions of scalars.

    The closed loop calls them for one machine at a time; ``jax.vmap`` makes the population::

        fixed = plant.coefficients(parameters)
        state = plant.initial_state(zero)
        readings = plant.signals(fixed, plant.measured(fixed, state))
        state = plant.step(fixed, state, plant.accepted(fixed, command), loads, dt)

    ``loads`` are the load at the start, the middle and the end of the step, because a
    fourth-order integrator asks for all three.
    """

    name: str
    #: Record class of the physical parameters; its defaults are the nominal machine.
    parameters: type[Any]
    #: What is wrong with a dict of changed parameters, in one line; None if nothing is.
    fault: Callable[[dict[str, float]], str | None]
    #: Unit of each signal, of "error", "error_rate", "command", "load" too, for people to read.
    units: dict[str, str]
    initial_state: Callable[[Any], Any]
    step: Callable[[Any, Any, Any, tuple[Any, Any, Any], Any], Any]
    #: Everything that a controller may read besides the tracking error and its rate.
    signals: Callable[[Any, Any], dict[str, Any]]
    #: State field that is to follow the reference, and the field of its rate.
    position: str
    velocity: str
    #: Each angle that an encoder reads, with the state field of its rate.
    encoders: dict[str, str]
    #: What a step needs of the parameters, computed once; the parameters themselves by default.
    coefficients: Callable[[Any], Any] = _as_it_is
    #: Parameters that are exact: counts, ratios of teeth, settings of the control. All others have
    #: a tolerance, because they were measured or identified, or change with load and warmth.
    exact: frozenset[str] = frozenset()
    #: Speed [of the position, per s] up to which an integration step of some length is stable.
    fastest: Callable[[Any, float], float] = _unlimited
    #: The command that reaches the drive, in the steps and within the limits of its converter.
    accepted: Callable[[Any, Any], Any] = _same
    #: The state as the control's own sensors report it, in their resolution.
    measured: Callable[[Any, Any], Any] = _same
    #: A reference (steps,) as the control is told it, in the steps of its interpolator.
    commanded: Callable[[Any], Any] = _as_it_is

    @property
    def command_name(self) -> str:
        """What the command is called: by its unit."""
        return COMMANDS.get(self.units["command"], "command")

    @property
    def load_name(self) -> str:
        """What the load is called: by its unit."""
        return LOADS.get(self.units["load"], "load")


def only_positive(parameters: type[Any]) -> Callable[[dict[str, float]], str | None]:
    """A ``Plant.fault``: every parameter has to be one of the record's and more than zero."""

    def fault(changes: dict[str, float]) -> str | None:
        for name, value in changes.items():
            if name not in parameters._fields:
                return f"parameters.{name}: unknown; there is {', '.join(parameters._fields)}"
            if not value > 0:
                return f"parameters.{name} = {value}: has to be more than zero"
        return None

    return fault


#: Signals that every plant has.
COMMON = ("error", "error_rate", "command", "load")


def plant_fault(plant: Plant) -> str | None:
    """What keeps a plant from working, in a line; None if nothing that is seen at once."""
    try:
        fixed = plant.coefficients(plant.parameters())
    except TypeError:
        return "each of its parameters needs a default, the nominal machine"
    state = plant.initial_state(0.0)
    signals = plant.signals(fixed, state)
    fields = [plant.position, plant.velocity, *plant.encoders, *plant.encoders.values()]
    faults = [
        *(f"units has no {key!r}" for key in (*COMMON, *signals) if key not in plant.units),
        *(f"{key!r} is a signal of the loop, not of the plant" for key in COMMON if key in signals),
        *(f"its state has no field {key!r}" for key in fields if key not in dir(state)),
        plant.fault({}),
    ]
    return next(filter(None, faults), None)
