"""``--to m``: a design as a function of MATLAB and Octave."""

import re

from hfc_design.codegen.matlab import program
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.formats import code
from hfc_design.formats.laws import recorded_law
from hfc_design.formats.writing import RESERVED, Format, rendered


def function(design: Design, name: str = "") -> str:
    """A function of MATLAB and Octave that commands what the runtime does.

    Raises:
        UserError: what it reads is not known, or a name is none of a field.
    """
    code.checked_numbers(design)
    known = code.flat(design)
    for signal in known.inputs:
        named("fis", signal)
    law = program(recorded_law(design, flat=True), [*known.inputs, *RESERVED["fis"]])
    values = {"name": name or code.c_name(design), "known": known, "law": law}
    values |= {"connection": design.connected}
    return rendered("controller.m.j2", design, **values)


def named(target: str, name: str) -> str:
    """``name``, which a field can have in MATLAB; UserError: it cannot."""
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,62}", name) or name in RESERVED.get(target, ()):
        raise UserError(f"--to {target}: {name} is no name of a field in MATLAB; rename it")
    return name


M = "a function of MATLAB and Octave with the controller, adaptation and all"
FORMATS = (Format("m", M, function, ".m", called=True, connects=True),)
