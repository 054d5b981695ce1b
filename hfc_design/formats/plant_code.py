"""C99 code of drives for LinuxCNC and FMUs; it computes each step as the simulator does."""

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

import jax

from hfc_design.codegen.c import C
from hfc_design.codegen.functions import Function, printed_function
from hfc_design.codegen.nodes import TraceError
from hfc_design.controllers.rules import identifier
from hfc_design.core.numbers import Json, Parameters
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.formats.writing import RESERVED, rendered
from plants import Drive, Machine
from plants.five_axis import FIVE_AXIS, FIVE_AXIS_B

#: Drive -> name of the code that it shares with other drives.
SHARED = {
    drive.name: f"servo_{'linear' if drive.degrees is None else 'rotary'}"
    for machine in (FIVE_AXIS, FIVE_AXIS_B)
    for drive in machine.drives
}


def name_of(drive: Drive) -> str:
    """Return the prefix of every public name in the C code of a drive."""
    return f"plant_{SHARED.get(drive.name, identifier(drive.name))}"


def check(drive: Drive, design: Design) -> None:
    """Check that a drive of the design's plant can be written in C; UserError: it cannot."""
    try:
        _functions(drive)
    except TraceError as error:
        message = f"cannot generate C of the drive {drive.name}: {error}"
        raise UserError(f"design {design.name}: {message}") from None


def state_units(drive: Drive) -> dict[str, str]:
    """Return the unit of every field of a drive's state, "" where it is not known."""
    units = {drive.position: drive.units["error"], drive.velocity: drive.units["error_rate"]}
    units |= drive.units | drive.state_units
    return {field: units.get(field, "") for field in drive.initial_state(0.0)._fields}


def signals(drive: Drive) -> list[str]:
    """Return the names of a drive's signals besides the error and its rate."""
    fixed = drive.coefficients(drive.parameters())
    return list(drive.signals(fixed, drive.measured(fixed, drive.initial_state(0.0))))


def counts(drive: Drive) -> bool:
    """True if the drive's own sensors report a position that differs from the true one."""
    return _functions(drive)["measured"].outputs[f"seen.{drive.position}"] != f"x->{drive.position}"


def sources(drive: Drive, design: Design) -> dict[str, str]:
    """Return file name -> text of header and source of a drive; UserError as for ``check``."""
    check(drive, design)
    functions = _functions(drive)
    library = dict.fromkeys(name for one in functions.values() for name in one.library)
    helpers = dict.fromkeys(name for one in functions.values() for name in one.helpers)
    nominal, units = drive.parameters(), drive.parameter_units
    values: Json = {"name": name_of(drive), "drive": drive, "functions": functions}
    values["parameters"] = {key: units.get(key, "") for key in nominal._fields}
    values["coefficients"] = coefficients(drive.coefficients(nominal))
    values["states"] = state_units(drive)
    values["signals"] = {name: drive.units[name] for name in signals(drive)}
    values |= {"library": [*library], "helpers": [C.helpers_of[name] for name in helpers]}
    files = {f"{values['name']}{end}": f"plants/plant{end}.j2" for end in (".h", ".c")}
    return {name: rendered(template, design, **values) for name, template in files.items()}


def coefficients(record: Parameters, prefix: str = "") -> dict[str, Any]:
    """Return name -> number of a record; the name of a nested record precedes those inside."""
    numbers: dict[str, Any] = {}
    for name, value in record._asdict().items():
        part = hasattr(value, "_asdict")
        numbers |= coefficients(value, f"{prefix}{name}_") if part else {prefix + name: value}
    return numbers


def coupled(machine: Machine, design: Design) -> dict[str, str]:
    """Return file name -> text of the step of coupled axes in C; UserError: it has no code."""
    count = len(machine.axes)
    given: Json = {"dt": 0.0}
    for k, drive in enumerate(machine.drives):
        given[f"c_{k}"] = jax.eval_shape(drive.coefficients, drive.parameters())
        given[f"x_{k}"] = drive.initial_state(0.0)
        given |= {f"command_{k}": 0.0, f"load_{k}": 0.0}

    def step(*values: Any) -> Any:
        by_name = dict(zip(given, values, strict=True))
        fixed, states, commands, loads = (
            tuple(by_name[f"{name}_{k}"] for k in range(count))
            for name in ("c", "x", "command", "load")
        )
        return machine.step(fixed, states, commands, tuple((x, x, x) for x in loads), by_name["dt"])

    try:
        printed = _printed(step, given, "")
    except TraceError as error:
        message = f"cannot generate C of the machine {machine.name}: {error}"
        raise UserError(f"design {design.name}: {message}") from None
    name = f"plant_{identifier(machine.name)}_step"
    values: Json = {"name": name, "machine": machine.name, "function": printed}
    values["drives"] = [name_of(drive) for drive in machine.drives]
    values["helpers"] = [C.helpers_of[one] for one in printed.helpers]
    files = {f"{name}{end}": f"plants/coupled{end}.j2" for end in (".h", ".c")}
    return {file: rendered(template, design, **values) for file, template in files.items()}


@cache
def _functions(drive: Drive) -> dict[str, Function]:
    """Return the functions in the C code of a drive, by name; TraceError: it has no code."""
    parameters = drive.parameters()
    fixed = jax.eval_shape(drive.coefficients, parameters)  # only their names are used
    state = drive.initial_state(0.0)
    known: Json = {"p": parameters, "c": fixed, "x": state, "seen": state}
    known |= dict.fromkeys(("command", "start", "middle", "end", "dt", "reference"), 0.0)

    def step(c: Any, x: Any, command: Any, start: Any, middle: Any, end: Any, dt: Any) -> Any:
        return drive.step(c, x, command, (start, middle, end), dt)

    made: dict[str, tuple[str, Callable[..., Any], str]] = {
        "prepare": ("p", drive.coefficients, "c->"),
        "accepted": ("c command", drive.accepted, ""),
        "step": ("c x command start middle end dt", step, "x->"),
        "measured": ("c x", drive.measured, "seen."),
        "told": ("c seen", drive.signals, "signals."),
        "commanded": ("reference", drive.commanded, ""),
    }
    return {
        name: _printed(function, {key: known[key] for key in given.split()}, place)
        for name, (given, function, place) in made.items()
    }


def _printed(function: Callable[..., Any], given: Mapping[str, Any], place: str) -> Function:
    """Return the C code of ``function``, whose arguments are like ``given``: records or numbers."""

    def named(results: Any) -> Mapping[str, Any]:
        if hasattr(results, "_asdict"):
            numbers = coefficients(results)
        elif isinstance(results, tuple):  # states of several axes
            each = [coefficients(one).items() for one in results]
            numbers = {f"x_{k}->{key}": x for k, state in enumerate(each) for key, x in state}
        else:
            numbers = dict(results) if isinstance(results, Mapping) else {"": results}
        return {f"{place}{key}": x for key, x in numbers.items()}

    taken = (*RESERVED["c"], *RESERVED["c-library"], *given, "signals", "loads", "commands")
    texts = [_texts(value, name) for name, value in given.items()]
    return printed_function(function, texts, C, taken, named)


def _texts(value: Any, name: str, part: str = "") -> Any:
    """Return ``value`` with the C expression of each number."""
    if hasattr(value, "_asdict"):
        head = f"{part}_" if part else ""
        items = value._asdict().items()
        return type(value)(*(_texts(x, name, head + key) for key, x in items))
    return f"{name}->{part}" if part else PLACES.get(name, name)


#: Argument of a step -> C expression, for arguments that are elements of an array.
PLACES = {"start": "loads[0]", "middle": "loads[1]", "end": "loads[2]"}
PLACES |= {f"{name}_{k}": f"{name}s[{k}]" for name in ("command", "load") for k in range(64)}
