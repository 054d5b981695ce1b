"""``--to m`` and ``--to js``: a design as a function of MATLAB, and as a module of JavaScript."""

import re

from hfc_design.codegen import javascript, matlab
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.formats import code
from hfc_design.formats.laws import recorded_law
from hfc_design.formats.writing import RESERVED, Format, comment, rendered


def function(design: Design, name: str = "") -> str:
    """A function of MATLAB and Octave that commands what the runtime does.

    Raises:
        UserError: what it reads is not known, or a name is none of a field.
    """
    code.checked_numbers(design)
    known = code.flat(design)
    for signal in known.inputs:
        named("fis", signal)
    law = matlab.program(recorded_law(design, flat=True), [*known.inputs, *RESERVED["fis"]])
    values = {"name": name or code.c_name(design), "known": known, "law": law}
    return rendered("controller.m.j2", design, connection=design.connected, **values)


def named(target: str, name: str) -> str:
    """``name``, which a field can have in MATLAB; UserError: it cannot."""
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,62}", name) or name in RESERVED.get(target, ()):
        raise UserError(f"--to {target}: {name} is not a valid field name in MATLAB; rename it")
    return name


def module(design: Design) -> str:
    """An ES module with ``initial()`` and ``step(state, inputs, limit)``, for a page or for Node.

    Raises:
        UserError: what it reads is not known, or a law does what no code can be made of.
    """
    code.checked_numbers(design)
    known = code.flat(design)
    values = {
        "name": code.c_name(design),
        "known": known,
        "meanings": dict(zip(known.meanings, comment(known.meanings.values()), strict=True)),
        "law": javascript.program(recorded_law(design), RESERVED["js"]),
    }
    return rendered("javascript.mjs.j2", design, connection=design.connected, **values)


M = "a function of MATLAB and Octave with the controller, including adaptation"
JS = "a module of JavaScript (ES) with the controller, including adaptation"
FORMATS = (
    Format("m", M, function, ".m", called=True, connects=True),
    Format("js", JS, module, ".mjs", called=True, connects=True),
)
