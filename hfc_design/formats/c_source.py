"""A controller as C99: a header and a source that do what ``runtime.Controller`` does."""

from pathlib import Path

from hfc_design.controllers.kind import Template, needed
from hfc_design.controllers.rules import identifier
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.formats.writing import (
    NO_CODE,
    RESERVED,
    Format,
    rendered,
    signal_units,
    signals_read,
    write,
)


def sources(design: Design, **others: object) -> dict[str, str]:
    """A folder with ``NAME.h`` and ``NAME.c``, NAME as ``c_name`` gives it.

    Raises:
        UserError: the kind has no C code, or an input is called like a word of the language.
    """
    template: Template = needed(design.kind.c, design, NO_CODE.format("C"))
    name = c_name(design)
    values = {
        "name": name,
        "signals": signals(design),
        "command_unit": signal_units(design).get("command", "unit"),
        "exponential": False,
        "integrates": False,
        **template.values(design.controller),
        **others,
    }
    files = {f"{name}.h": "c/header.h.j2", f"{name}.c": "c/source.c.j2"}
    return {key: rendered(file, design, template.places, **values) for key, file in files.items()}


def write_lookup(design: Design, path: Path, points: int) -> str:
    """Write the same without ``exp``: degrees tabulated at ``points`` values, linear in between.

    Returns:
        The largest deviation from the exact command that was found, with the command's unit.

    Raises:
        UserError: the controller has no terms with an exponential; or as ``sources``.
        RunError: the folder ``path`` cannot be written.
    """
    lookup = needed(design.kind.lookup, design, "nothing to tabulate, its C code needs no exp")
    values = lookup(design.controller, points)
    write(path, sources(design, **values))
    return f"{values['deviation']:.2g} {signal_units(design).get('command', '')}"


def c_name(design: Design) -> str:
    """What every name in the C code of a design begins with."""
    name = identifier(design.name)
    return name if name[:1].isalpha() else f"hfc_{name}"


def signals(design: Design) -> dict[str, str]:
    """What the controller reads at a sample, and its unit where that is known.

    Raises:
        UserError: an input is called like a word of the language.
    """
    found = signals_read(design)
    for name in found:
        if name in RESERVED["c"] or name.startswith("_"):
            raise UserError(f"design {design.name}: an input named {name} cannot be one in C")
    return found


FORMATS = (Format("c", "a folder with the controller in C99, adaptation and all", sources),)
