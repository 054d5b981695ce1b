"""``--to st``: a design as a function block, with the files that test it."""

import re
from typing import NamedTuple

from hfc_design.codegen.st import Block, program
from hfc_design.controllers.rules import identifier
from hfc_design.files.design import Design
from hfc_design.formats import code, saving
from hfc_design.formats.deployment import readme
from hfc_design.formats.deployment.folder import page_of_axes, table
from hfc_design.formats.deployment.vectors import of_the_last_digit, vectors
from hfc_design.formats.laws import recorded_law
from hfc_design.formats.writing import RESERVED, Content, Format, check_names, rendered

#: Largest assumed difference between implementations of ``EXP``, in units of the last digit.
EXP_OFF = 8.0
CLASH = "IEC 61131-3 reads {name} as {other}"


class FunctionBlock(NamedTuple):
    """Design as a function block."""

    name: str
    known: code.Flat
    law: Block


def block_of(design: Design) -> FunctionBlock:
    """Return the function block of a design; UserError: an input, a number or a name is invalid."""
    name = "fb_" + re.sub("_+", "_", identifier(design.name)).strip("_")
    known = code.flat(design)
    check_names("st", [name, "reset", *known.outputs, "fault", *known.inputs], CLASH)
    code.checked_numbers(design)
    law = recorded_law(design, flat=True)
    return FunctionBlock(name, known, program(law, known.outputs, [name, *RESERVED["st"]]))


def text_of(design: Design) -> str:
    """Return ``design`` as a function block of Structured Text; UserError as for ``block_of``."""
    return rendered("controller.st.j2", design, block=block_of(design))


def with_vectors(design: Design, files: dict[str, str]) -> dict[str, Content]:
    """Return the block's ``files`` with README page, test vectors and a program that runs them."""
    block = block_of(design)
    program = f"{block.name}_check"
    check_names("st", [block.name, program, "controller"], CLASH)
    test_vectors = vectors(design)
    if saving.learns(design) and "EXP(" in block.law.body:
        far = max(test_vectors.tolerance.double, EXP_OFF * of_the_last_digit(design, test_vectors))
        test_vectors = test_vectors._replace(tolerance=test_vectors.tolerance._replace(double=far))
    values = readme.values(design, test_vectors) | {"block": block, "program": program}
    values["files"] = list(files)
    values["resets"] = [k for k, reset in enumerate(test_vectors.resets) if reset]
    values["remembered"] = sum(x.size or 1 for x in block.law.remembered if x.type == "LREAL")
    check = {"vectors.csv": table(design, test_vectors)}
    check["check.st"] = rendered("deployment/check.st.j2", design, **values)
    page = rendered("deployment/plc.md.j2", design, **values)
    return {**files, "README.md": page, "check": check}


def folder(design: Design) -> Content:
    """Return the files of a design as a function block; UserError as for ``block_of``."""
    return with_vectors(design, {f"{code.c_name(design)}.st": text_of(design)})


ST = "a folder with a function block in Structured Text (IEC 61131-3), a README and a check"
FORMATS = (Format("st", ST, folder, companions=page_of_axes, connects=True),)
