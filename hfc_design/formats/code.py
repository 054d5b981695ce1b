"""A controller as a header and a source of C99, which do what ``runtime.Controller`` does."""

from collections.abc import Iterable, Iterator

from hfc_design.codegen.c import program
from hfc_design.controllers.controller import AxisLaw
from hfc_design.controllers.kind import needed
from hfc_design.controllers.rules import identifier
from hfc_design.core.numbers import Json, Plain
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.formats import saving, writing
from hfc_design.formats.laws import recorded_law

#: How names of the C code end that others see.
PUBLIC = ("real", "inputs", "state", "init", "step", "step_within", "save", "load", "rest")
#: What a kind lacks that has no template of a language.
NO_CODE = "it has no template in {}; json holds its numbers"
#: Largest number of a design: no sum or product of what the law is made of overflows.
LARGEST = 1e100
#: The same where it adapts: there a difference of 1e-4 decides, so that it has to be seen.
LARGEST_LEARNT = 1e9
#: What single precision holds with room for products, beside 0.
SINGLE = (1e-30, 1e12)


def sources(
    design: Design, law: AxisLaw | None = None, notes: Iterable[str] = ()
) -> dict[str, str]:
    """A folder with ``NAME.h`` and ``NAME.c``, NAME as ``c_name`` gives it.

    ``law`` is another one for the same numbers, as that of tabulated terms; ``notes`` stand in the
    head.

    Raises:
        UserError: the kind has no C code, or an input is called like a word of the language.
    """
    names, kind = signals(design), design.kind
    needed(kind.law, design, NO_CODE.format("C"))
    numbers = checked_numbers(design)
    name, told = c_name(design), writing.signal_meanings(design)
    change = design.changes([design.axis])[design.axis]
    found = recorded_law(design.controller, change, law)
    reserved = [*writing.RESERVED["c"], *writing.RESERVED["c-library"]]
    reserved += [f"{name}_{one}" for one in PUBLIC]
    values = {
        "name": name,
        "head": writing.head(design, notes),
        "signals": names,
        "meanings": dict(zip(told, writing.comment(told.values()), strict=True)),
        "command_unit": writing.signal_units(design).get("command", "unit"),
        "only_double": only_double(numbers, kind.widths(design.controller)),
        "saved": saving.values(design),
        "law": program(found, reserved),
    }
    files = {f"{name}.h": "c/header.h.j2", f"{name}.c": "c/source.c.j2"}
    return {key: writing.rendered(file, design, **values) for key, file in files.items()}


def tabulated(design: Design, points: int) -> tuple[dict[str, str], Json]:
    """The same without ``exp``: degrees tabulated at ``points`` values, linear in between.

    Returns:
        The files, and what ``Kind.lookup`` gives.

    Raises:
        UserError: the controller has no terms with an exponential; or as ``sources``.
    """
    lookup = needed(design.kind.lookup, design, "nothing to tabulate, its C code needs no exp")
    values = lookup(design.controller, points)
    of, unit = values["deviates"], writing.signal_units(design).get(values["deviates"], "")
    far = f"{values['deviation']:.2g} {unit}".rstrip()
    notes = [
        f"terms tabulated at {points} values, linear in between",
        f"the largest deviation from the exact {of} that a search found is {far}",
    ]
    return sources(design, values["law"](None), notes), values


def c_name(design: Design) -> str:
    """What every name in the C code of a design begins with."""
    name = identifier(design.name)
    return name if name[:1].isalpha() else f"hfc_{name}"


def signals(design: Design) -> dict[str, str]:
    """What the controller reads at a sample, and its unit where that is known.

    Raises:
        UserError: an input is called like a word of the language.
    """
    found = writing.signals_read(design)
    for name in found:
        if name in writing.RESERVED["c"] or name.startswith("_"):
            raise UserError(f"design {design.name}: an input named {name} cannot be one in C")
    return found


def checked_numbers(design: Design) -> list[tuple[str, float]]:
    """Every number of the controller and its limits by its dotted key.

    Raises:
        UserError: one is too large for code that does what the runtime does.
    """
    whole = {"controller": design.controller.model_dump(), "limits": design.limits.model_dump()}
    learns = saving.learns(design)
    largest = LARGEST_LEARNT if learns else LARGEST
    numbers = list(_numbers(whole))
    for key, x in numbers:
        if not abs(x) <= largest:
            bound = f"{largest:g}{' where it adapts' if learns else ''}"
            told = f"{key} = {x:g}: code takes numbers up to {bound}"
            raise UserError(f"design {design.name}: {told}")
    return numbers


def only_double(numbers: list[tuple[str, float]], widths: Iterable[float]) -> str:
    """Why a design with these numbers and widths of terms does not fit into float; "": it does."""
    smallest, largest = SINGLE
    odd = [f"{key} is {x:g}" for key, x in numbers if x and not smallest < abs(x) < largest]
    odd += ["a term has no width" for width in widths if width < smallest]
    return writing.comment(odd[:1])[0] if odd else ""


def _numbers(value: Plain, key: str = "") -> Iterator[tuple[str, float]]:
    """Every number in a table by its dotted key."""
    if isinstance(value, dict | list | tuple):
        for name, part in value.items() if isinstance(value, dict) else enumerate(value):
            yield from _numbers(part, f"{key}.{name}".lstrip("."))
    elif isinstance(value, int | float):
        yield key, value
