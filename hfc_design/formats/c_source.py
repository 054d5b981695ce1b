"""A controller as C99: a header and a source that do what ``runtime.Controller`` does."""

from pathlib import Path
from typing import Any

from hfc_design.controllers.kind import Template, needed
from hfc_design.controllers.rules import identifier
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.formats.format import Format
from hfc_design.formats.writing import (
    NO_CODE,
    RESERVED,
    comment,
    facts,
    rendered,
    signal_units,
    write_folder,
)

#: What a kind's values say beside what only its own template reads.
USUAL = {"exponential": False, "integrates": False}


def write(design: Design, path: Path) -> None:
    """Write the folder ``path`` with ``NAME.h`` and ``NAME.c``, NAME as ``c_name`` gives it.

    Raises:
        UserError: the kind has no C code, or an input is called like a word of the language.
        RunError: the folder cannot be written.
    """
    _write(design, path, {})


def write_lookup(design: Design, path: Path, points: int) -> str:
    """The same without ``exp``: degrees tabulated at ``points`` values, linear in between.

    Returns:
        The largest deviation from the exact command that was found, with the command's unit.

    Raises:
        UserError: the controller has no terms with an exponential; or as ``write``.
    """
    lookup = needed(design.kind.lookup, design, "nothing to tabulate, its C code needs no exp")
    values = lookup(design.controller, points)
    _write(design, path, values)
    return f"{values['deviation']:.2g} {signal_units(design).get('command', '')}"


def c_name(design: Design) -> str:
    """What every name in the C code of a design begins with."""
    name = identifier(design.name)
    return name if name[:1].isalpha() else f"hfc_{name}"


def signals(design: Design) -> dict[str, str]:
    """What the controller reads at a sample, and its unit where that is known.

    Raises:
        UserError: the kind has no C code, or an input is called like a word of the language.
    """
    _template(design)
    names, units = design.kind.reads(design.controller), signal_units(design)
    for name in names:
        if name in RESERVED["c"] or name.startswith("_"):
            raise UserError(f"design {design.name}: an input named {name} cannot be one in C")
    return {identifier(name): units.get(name, "") for name in names}


def _template(design: Design) -> Template:
    found: Template = needed(design.kind.c, design, NO_CODE)
    return found


def _write(design: Design, path: Path, others: dict[str, Any]) -> None:
    name, template = c_name(design), _template(design)
    values = {
        "name": name,
        "head": comment(facts(design)),
        "signals": signals(design),
        "command_unit": signal_units(design).get("command", "unit"),
        "every": design.controller.sample_time_s,
        "limit": design.limits.command,
        **USUAL,
        **template.values(design.controller),
        **others,
    }
    files = {f"{name}.h": "c/header.h.j2", f"{name}.c": "c/source.c.j2"}
    texts = {key: rendered(file, design, template.places, **values) for key, file in files.items()}
    write_folder(path, texts)


FORMATS = (Format("c", "a folder with the controller in C99, adaptation and all", write),)
