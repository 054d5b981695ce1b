"""Definition of a drive: one axis with one command. A user can write one in thirty lines."""

import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from functools import cache
from math import inf
from typing import Any, TypeAlias, get_type_hints

#: Number of one axis: a float, an array over axes, or a value being traced by JAX.
Scalar: TypeAlias = Any
#: Types known to a drive only: the record of its parameters, what a step needs of them, its state.
Parameters: TypeAlias = Any
Coefficients: TypeAlias = Any
State: TypeAlias = Any
Loads: TypeAlias = tuple[Scalar, Scalar, Scalar]  # at the start, the middle, the end of a step

#: Names of a command and a load by their units; others are just "command" and "load".
COMMANDS = {"V": "voltage", "A": "current", "N m": "torque"}
LOADS = {"N m": "load_torque", "N": "force"}


#: Function that tells whether a parameter may have a value, and the allowed values in words.
Allowed: TypeAlias = tuple[Callable[[float], bool], str]
POSITIVE: Allowed = (lambda value: value > 0, "greater than 0")
NOT_NEGATIVE: Allowed = (lambda value: value >= 0, "at least 0")


def in_a_name(unit: str) -> str:
    """Return ``unit`` as the end of the name of a column or metric: rad/s as rad_s, N m as Nm."""
    return unit.replace(" ", "").replace("/", "_")


@dataclass(frozen=True, eq=False)  # compared by identity: a drive is a key of compiled code
class Drive:
    """A drive as data and pure functions of scalars.

    The closed loop calls them for one machine at a time; ``jax.vmap`` makes the population::

        fixed = drive.coefficients(parameters)
        state = drive.initial_state(zero)
        readings = drive.signals(fixed, drive.measured(fixed, state))
        state = drive.step(fixed, state, drive.accepted(fixed, command), loads, dt)

    ``loads`` are the load at the start, the middle and the end of the step, because a
    fourth-order integrator asks for all three.
    """

    name: str
    #: Record class of the physical parameters; its defaults are the nominal machine.
    parameters: type[Parameters]
    #: Fault of a dict of changed parameters, in one line; None if there is none.
    fault: Callable[[dict[str, float]], str | None]
    #: Unit of each signal, of "error", "error_rate", "command", "load" too, for people to read.
    units: dict[str, str]
    initial_state: Callable[[Scalar], State]
    step: Callable[[Coefficients, State, Scalar, Loads, Scalar], State]
    #: Signals that a controller may read besides the tracking error and its rate.
    signals: Callable[[Coefficients, State], dict[str, Scalar]]
    #: State field that is to follow the reference, and the field of its rate.
    position: str
    velocity: str
    #: Angles that encoders read, each with the state field of its rate.
    encoders: dict[str, str]
    #: Quantities that a step needs of the parameters, computed once; by default the parameters.
    coefficients: Callable[[Parameters], Coefficients] = lambda parameters: parameters
    #: Parameters that are exact: counts, ratios of teeth, settings of the control. All others have
    #: a tolerance, because they were measured or identified, or change with load and warmth.
    exact: frozenset[str] = frozenset()
    #: Speed [of the position, per s] up to which an integration step of some length is stable.
    fastest: Callable[[Parameters, float], float] = lambda parameters, dt: inf
    #: Command that reaches the drive, in the steps and within the limits of its converter.
    accepted: Callable[[Coefficients, Scalar], Scalar] = lambda fixed, command: command
    #: State as the control's own sensors report it, in their resolution.
    measured: Callable[[Coefficients, State], State] = lambda fixed, state: state
    #: Parameter that is the step of an encoder, by the name of its angle; other encoders are exact.
    resolutions: dict[str, str] = field(default_factory=dict)
    #: Reference (steps,) as given to the control, in the steps of its interpolator.
    commanded: Callable[[Scalar], Scalar] = lambda reference: reference
    #: State field that the control measures and feeds back, and the field of its rate, for example
    #: for an encoder on the motor. None: ``position`` and ``velocity``, as of a scale on a table.
    feedback: tuple[str, str] | None = None
    #: Length of a unit of the position [mm]; None: not a length, so no path can be followed.
    millimetres: Callable[[Parameters], float] | None = None
    #: Angle of a unit of the position [deg]; None: not an angle. A G-code program moves either.
    degrees: Callable[[Parameters], float] | None = None
    #: Speed [of the position, per s] that the largest command holds; a faster path is refused.
    top_speed: Callable[[Parameters], float] = lambda parameters: inf
    #: K and tau of K/(s (tau s + 1)), if that is the drive without its friction.
    linear: Callable[[Parameters], tuple[float, float]] | None = None
    #: Unit of each parameter, for people to read; left out: those of ``Annotated[float, "kg"]``.
    parameter_units: dict[str, str] = field(default_factory=dict)
    #: Unit of each field of the state that is no signal, for people to read.
    state_units: dict[str, str] = field(default_factory=dict)
    #: Meaning and positive direction of each signal or the command; left out: its name only.
    meanings: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not self.parameter_units:
            object.__setattr__(self, "parameter_units", annotated_units(self.parameters))

    def __repr__(self) -> str:
        return f"Drive({self.name!r}: {len(self.parameters._fields)} parameters)"

    @property
    def seen(self) -> tuple[str, str]:
        """State fields of the position and the velocity that are fed back."""
        return self.feedback or (self.position, self.velocity)

    @property
    def off_its_position(self) -> bool:
        """True if the position that is fed back is not the one that is to follow the reference."""
        return self.seen[0] != self.position

    @property
    def inputs(self) -> list[str]:
        """Signals that a controller can read."""
        return [name for name in self.units if name not in ("command", "load")]

    def largest_commands(
        self, parameters: Parameters, limit: float | None = None
    ) -> tuple[float, float]:
        """Return the lowest and the highest command that reach the drive; infinite without a limit.

        ``limit`` is an outer limit before the drive's own; None if there is none.
        """
        fixed = self.coefficients(parameters)
        limit = inf if limit is None else limit
        return float(self.accepted(fixed, -limit)), float(self.accepted(fixed, limit))

    @property
    def command_name(self) -> str:
        """Name of the command, by its unit."""
        return COMMANDS.get(self.units["command"], "command")

    @property
    def load_name(self) -> str:
        """Name of the load, by its unit."""
        return LOADS.get(self.units["load"], "load")


@cache  # always the same object for a drive and an encoder: it is a key of compiled code
def fed_back(drive: Drive, encoder: str) -> Drive:
    """Return the drive with feedback from one of its encoders."""
    return replace(drive, feedback=(encoder, drive.encoders[encoder]))


def only_positive(
    parameters: type[Parameters], /, **others: Allowed
) -> Callable[[dict[str, float]], str | None]:
    """Return a ``Drive.fault``: every parameter must be one of the record's and more than zero.

    ``others`` gives other allowed values of single parameters.
    """

    def fault(changes: dict[str, float]) -> str | None:
        for name, value in changes.items():
            if name not in parameters._fields:
                near = get_close_matches(name, parameters._fields, 1)
                meant = f"did you mean {near[0]}? " if near else ""
                known = ", ".join(parameters._fields)
                return f"parameters.{name}: unknown; {meant}available: {known}"
            allowed, words = others.get(name, POSITIVE)
            if not allowed(value):
                return f"parameters.{name} = {value}: must be {words}"
        return None

    return fault


def annotated_units(parameters: type[Parameters]) -> dict[str, str]:
    """Return the units of a record whose fields are like ``mass: Annotated[float, "kg"]``."""
    try:
        hints = get_type_hints(parameters, include_extras=True).items()
    except (NameError, TypeError):  # names that are known only where a user's class is defined
        return {}
    each = ((name, unit) for name, hint in hints for unit in getattr(hint, "__metadata__", ()))
    return {name: unit for name, unit in each if isinstance(unit, str)}


def units_in(position: str, command: str, load: str) -> dict[str, str]:
    """Return ``Drive.units`` of a drive whose only own signals are its position and velocity."""
    signal_units = {
        "error": position,
        "error_rate": f"{position}/s",
        "command": command,
        "load": load,
    }
    return signal_units | {"position": position, "velocity": f"{position}/s"}


#: Allowed units: their text must not end a comment of generated code, or a command, around it.
UNIT = re.compile(r"[\w /.^%°·()+-]{0,32}")
#: Allowed name of a signal or an axis, in every language.
NAME = re.compile(r"[A-Za-z_]\w{0,31}", re.ASCII)
NAMED = "at most 32 letters, digits and _"
UNITS = "at most 32 letters, digits, spaces and /.^%°·()+-"
#: Signals that every drive has.
COMMON = ("error", "error_rate", "command", "load")


def called(thing: Any, part: str, *given: Any) -> Any:
    """Return the result of a function of a drive or machine; an error gets ``part`` as a note."""
    try:
        return getattr(thing, part)(*given)
    except Exception as error:  # whatever the user's code raises
        error.add_note(part)
        raise


def drive_fault(drive: Drive) -> str | None:
    """Return a line on why a drive cannot work; None if no fault is found without a simulation."""
    try:
        parameters = drive.parameters()
    except TypeError:
        return "each of its parameters must have a default, the nominal machine"
    fixed = called(drive, "coefficients", parameters)
    state = called(drive, "initial_state", 0.0)
    signals = called(drive, "signals", fixed, called(drive, "measured", fixed, state))
    if not isinstance(signals, dict):
        return f"signals must return a dict (got {signals!r})"
    fields = [drive.position, drive.velocity, *drive.seen]
    fields += [*drive.encoders, *drive.encoders.values()]
    units, meanings = (
        [*drive.units.values(), *drive.parameter_units.values()],
        drive.meanings.values(),
    )
    of_parameters = {"exact": drive.exact, "parameter_units": drive.parameter_units}
    of_parameters["resolutions"] = drive.resolutions.values()
    faults = [
        *(f"units must have {key!r}" for key in (*COMMON, *signals) if key not in drive.units),
        *(
            f"signals must not have {key!r}, a signal of the loop"
            for key in COMMON
            if key in signals
        ),
        *(f"its state must have a field {key!r}" for key in fields if key not in dir(state)),
        *(
            f"{key}: unknown parameter {x!r}"
            for key, names in of_parameters.items()
            for x in names
            if x not in dir(parameters)
        ),
        *(f"meanings: unknown signal {x!r}" for x in drive.meanings if x not in drive.units),
        *(f"meanings: {x!r} must be a single line" for x in meanings if not x.isprintable()),
        *(f"the unit {x!r} must be {UNITS}" for x in units if not UNIT.fullmatch(x)),
        *(f"the signal {x!r} must be {NAMED}" for x in drive.units if not NAME.fullmatch(x)),
        called(drive, "fault", {}),
    ]
    return next(filter(None, faults), None)
