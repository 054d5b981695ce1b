"""C99 header and source of a controller; the code computes what ``runtime.Controller`` computes."""

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from hfc_design.codegen.c import program
from hfc_design.codegen.recorded import PATH
from hfc_design.controllers.controller import AxisLaw
from hfc_design.controllers.kind import require
from hfc_design.controllers.rules import identifier
from hfc_design.core.numbers import Json, Plain
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.formats import saving, writing
from hfc_design.formats.laws import inside, machine_axes, of_path, recorded_law

#: C expressions of the path values in the code of a controller of a whole machine.
IN_PATH = ("path->tangent[0]", "path->tangent[1]", "path->curvature", "path->contour_error")
#: Meanings of the path values.
OF_PATH = (
    "along X, of the unit vector along the path",
    "along Y, of the unit vector along the path",
    "of the path, positive to the left",
    "of the measured position, positive to the left of the path",
)
#: Further names that are taken in the code of a controller of a whole machine.
OF_MACHINES = ("axes", "path", "command", "AXES")
#: Suffixes of the public names in the C code.
PUBLIC = ["real", "inputs", "state", "init", "step", "step_within", "save", "load", "rest"]
PUBLIC += ["path", "contour_error"]
#: Largest magnitude of a number of a design, so that no sum or product in its law overflows.
LARGEST = 1e100
#: The same for a design that adapts: its decisions need differences of 1e-4 despite rounding.
LARGEST_LEARNT = 1e9
#: Range of magnitudes (besides 0) whose products still fit into single precision.
SINGLE = (1e-30, 1e12)


def sources(
    design: Design, law: AxisLaw | None = None, notes: Iterable[str] = ()
) -> dict[str, str]:
    """Return ``NAME.h`` and ``NAME.c`` of a controller, with NAME from ``c_name``.

    If ``law`` is given, for example a law with tabulated terms, the code computes it instead of the
    design's own law, with the same numbers. ``notes`` are printed in the head comment.

    Raises:
        UserError: the kind has no C code, or a name or a number is not allowed in C.
    """
    names, whole = signals(design), machine_axes(design)
    axes, numbers = [*map(identifier, whole)], checked_numbers(design)
    name, meanings = c_name(design), writing.signal_meanings(design)
    places = dict(zip(PATH, IN_PATH, strict=True))
    for k, axis in enumerate(axes):
        places |= {f"{axis}_{signal}": f"axes[{k}].{signal}" for signal in names}
    parts = inside(design.controller, whole)
    widths = [width for part in parts for width in part.widths()]
    reserved = [*writing.RESERVED["c"], *writing.RESERVED["c-library"]]
    reserved += [f"{name}_{public}" for public in PUBLIC]
    reserved += OF_MACHINES if axes else ()
    values: Json = {"name": name, "head": writing.head(design, notes), "signals": names}
    values |= {"axes": axes, "path": of_path(design), "connection": design.connected}
    values |= {"only_double": only_double(numbers, widths), "saved": saving.learning(design)}
    values["meanings"] = dict(zip(meanings, writing.comment(meanings.values()), strict=True))
    values["command_unit"] = writing.signal_units(design).get("command", "unit")
    values["law"] = program(recorded_law(design, law), reserved, places if axes else {})
    if axes:
        values["limit"] = any(design.limits.commands(whole).values())
        values["change"] = any(design.changes(whole).values())
    files = {f"{name}.h": "c/header.h.j2", f"{name}.c": "c/source.c.j2"}
    return {key: writing.rendered(file, design, **values) for key, file in files.items()}


def tabulated(design: Design, points: int) -> tuple[dict[str, str], Json]:
    """Return C sources without ``exp``: degrees are interpolated in a table of ``points`` values.

    Returns:
        The files by name, and the result of ``ControllerRecord.lookup``.

    Raises:
        UserError: the controller has no terms with an exponential; or in the cases of ``sources``.
    """
    lookup = require(design.kind.lookup, design, "its C code has no exp to tabulate")
    values = lookup(design.controller, points)
    of, unit = values["deviates"], writing.signal_units(design).get(values["deviates"], "")
    far = f"{values['deviation']:.2g} {unit}".rstrip()
    notes = [
        f"terms tabulated at {points} values, linear in between",
        f"the largest deviation from the exact {of} that a search found is {far}",
    ]
    return sources(design, values["law"](None), notes), values


def c_name(design: Design) -> str:
    """Return the prefix of every public name in the C code of a design."""
    name = identifier(design.name)
    return name if name[:1].isalpha() else f"hfc_{name}"


def signals(design: Design) -> dict[str, str]:
    """Return identifier and unit ("" if unknown) of each signal that the controller reads.

    Raises:
        UserError: the signals are not known, or a name is not allowed in C.
    """
    read = writing.signals_read(design)
    for name in read:
        if name in writing.RESERVED["c"] or name.startswith("_"):
            raise UserError(f"design {design.name}: the input name {name} is not allowed in C")
    return read


class Flat(NamedTuple):
    """Inputs and outputs of a controller as single variables, without arrays over axes."""

    inputs: dict[str, str]  # name -> unit, "" if unknown
    outputs: list[str]  # names of the commands
    unit: str  # of the commands
    meanings: dict[str, str]  # name -> meaning, without names of unknown meaning
    truths: list[str] = []  # inputs that are true or false, in languages with such a type


def flat(design: Design) -> Flat:
    """Return inputs and commands of a design; for a machine, names begin with that of their axis.

    Raises:
        UserError: the signals that the controller reads are not known.
    """
    read, unit = writing.signals_read(design), writing.signal_units(design).get("command", "")
    truths = design.connected.truths if design.connected else []
    if not (axes := machine_axes(design)):
        return Flat(read, ["command"], unit, writing.signal_meanings(design), truths)
    heads, each = [f"{identifier(axis)}_" for axis in axes], writing.each_axis(design)
    inputs: dict[str, str] = {}
    meanings: dict[str, str] = {}
    for axis, head in zip(axes, heads, strict=True):
        units, meanings_of = each.get(axis) or each[""]
        inputs |= {f"{head}{x}": units.get(x, "") for x in read}
        meanings |= {f"{head}{x}": meanings_of[x] for x in (*read, "command") if x in meanings_of}
    for name, (of, what) in path_inputs(design).items():
        inputs[name], meanings[name] = of, what
    truths = [f"{head}{name}" for head in heads for name in truths]
    return Flat(inputs, [f"{head}command" for head in heads], unit, meanings, truths)


def path_inputs(design: Design) -> dict[str, tuple[str, str]]:
    """Return unit and meaning of each path value that the controller of a machine reads."""
    place = next(iter(writing.each_axis(design).values()))[0].get("error", "")
    units = ("1", "1", place and f"1/{place}", place)
    return dict(zip(of_path(design), zip(units, OF_PATH, strict=True), strict=False))


def checked_numbers(design: Design) -> list[tuple[str, float]]:
    """Return (dotted key, number) for all numbers of the controller and of its limits.

    Raises:
        UserError: a number exceeds ``LARGEST``, or ``LARGEST_LEARNT`` if the design learns.
    """
    whole = {"controller": design.controller.model_dump(), "limits": design.limits.model_dump()}
    learns = saving.learns(design)
    largest = LARGEST_LEARNT if learns else LARGEST
    numbers = [*_numbers(whole)]
    for key, x in numbers:
        if not abs(x) <= largest:
            message = f"{key} = {x:g}: must be within ±{largest:g} in code"
            raise UserError(f"design {design.name}: {message}{' that adapts' * learns}")
    return numbers


def only_double(numbers: list[tuple[str, float]], widths: Iterable[float]) -> str:
    """Return why code with these numbers and term widths must be in double; "" if float will do."""
    smallest, largest = SINGLE
    odd = [f"{key} is {x:g}" for key, x in numbers if x and not smallest < abs(x) < largest]
    odd += ["a term has no width" for width in widths if width < smallest]
    return writing.comment(odd[:1])[0] if odd else ""


def _numbers(value: Plain, key: str = "") -> Iterator[tuple[str, float]]:
    """Yield (dotted key, number) for all numbers in nested tables; ``key`` is that of ``value``."""
    if isinstance(value, dict | list | tuple):
        for name, part in value.items() if isinstance(value, dict) else enumerate(value):
            yield from _numbers(part, f"{key}.{name}".lstrip("."))
    elif isinstance(value, int | float):
        yield key, value
