"""``--to st``: a design as a function block, and all one needs to trust it."""

import re
from typing import NamedTuple

from hfc_design.codegen.st import Block, literal_of, program
from hfc_design.controllers.rules import identifier
from hfc_design.files.design import Design
from hfc_design.formats import code, saving
from hfc_design.formats.flash import readme
from hfc_design.formats.flash.folder import page_of_axes, table
from hfc_design.formats.flash.vectors import vectors
from hfc_design.formats.laws import flat_law
from hfc_design.formats.writing import (
    RESERVED,
    Content,
    Format,
    check_names,
    rendered,
    signal_units,
    signals_read,
)

CLASH = "IEC 61131-3 takes {name} for {other}"


class FunctionBlock(NamedTuple):
    """A design as one."""

    name: str
    signals: dict[str, str]  # what it reads and in which unit
    law: Block


def block_of(design: Design) -> FunctionBlock:
    """The function block of a design.

    Raises:
        UserError: the kind is none of an axis, or a name is none of the language.
    """
    name = "fb_" + re.sub("_+", "_", identifier(design.name)).strip("_")
    signals = signals_read(design)
    check_names("st", [name, "reset", "command", "fault", *signals], CLASH)
    code.checked_numbers(design)
    return FunctionBlock(name, signals, program(flat_law(design), [name, *RESERVED["st"]]))


def text_of(design: Design) -> str:
    """``design`` as one function block of Structured Text; UserError as ``block_of``."""
    return rendered("controller.st.j2", design, block=block_of(design), literal=literal_of)


def with_vectors(design: Design, files: dict[str, str]) -> dict[str, Content]:
    """The block in whatever form, with a page, vectors and a program that runs them.

    Raises:
        UserError: as ``block_of``.
    """
    block = block_of(design)
    program = f"{block.name}_check"
    check_names("st", [block.name, program, "controller"], CLASH)
    found = vectors(design)
    values = readme.values(design, found) | {
        "name": block.name,
        "program": program,
        "files": list(files),
        "inputs": list(block.signals),
        "expected": [float(command) for (command,) in found.commands],
        "columns": [list(map(float, column)) for column in zip(*found.inputs, strict=True)],
        "resets": [k for k, reset in enumerate(found.resets) if reset],
        "learns": design.kind.adapted is not None and saving.learns(design),
        "remembered": sum(x.size or 1 for x in block.law.remembered if x.type == "LREAL"),
        "unit": signal_units(design).get("command", ""),
        "literals": lambda row: ", ".join(map(literal_of, row)),
    }
    check = {
        "check.st": rendered("flash/check.st.j2", design, **values),
        "vectors.csv": table(design, found),
    }
    return {**files, "README.md": rendered("flash/plc.md.j2", design, **values), "check": check}


def folder(design: Design) -> Content:
    """The function block of a design, its page, its vectors, and a program that runs them.

    Raises:
        UserError: as ``block_of``.
    """
    return with_vectors(design, {f"{code.c_name(design)}.st": text_of(design)})


ST = "a folder with a function block in Structured Text (IEC 61131-3), a page on it and its check"
FORMATS = (Format("st", ST, folder, beside=page_of_axes),)
