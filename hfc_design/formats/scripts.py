"""``--to m`` and ``--to js``: a design as a function of MATLAB, and as a module of JavaScript."""

import re

from hfc_design.codegen import javascript, matlab
from hfc_design.core.records import UserError, option
from hfc_design.files.design import Design
from hfc_design.formats import code
from hfc_design.formats.laws import recorded_law
from hfc_design.formats.writing import RESERVED, Format, comment, rendered


def function(design: Design, name: str = "") -> str:
    """Return a function for MATLAB and Octave that computes the commands of the runtime.

    Raises:
        UserError: the inputs are not known, a number is too large, or a name is not allowed.
    """
    code.checked_numbers(design)
    known = code.flat(design)
    for signal in known.inputs:
        named("fis", signal)
    law = matlab.program(recorded_law(design, flat=True), [*known.inputs, *RESERVED["fis"]])
    values = {"name": name or code.c_name(design), "known": known, "law": law}
    return rendered("controller.m.j2", design, connection=design.connected, **values)


def named(target: str, name: str) -> str:
    """Return ``name`` if it can be a field in MATLAB; UserError otherwise."""
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,62}", name) or name in RESERVED.get(target, ()):
        fault = f"{name} is not a valid field name in MATLAB; rename it"
        raise UserError(f"{option('to', target)}: {fault}")
    return name


def module(design: Design) -> str:
    """Return an ES module with ``initial()`` and ``step(state, inputs, limit)``.

    It runs in a browser or in Node. For a whole machine ``step`` has no ``limit``.

    Raises:
        UserError: the inputs are not known, a number is too large, or no code can be generated.
    """
    code.checked_numbers(design)
    known = code.flat(design)
    meanings = dict(zip(known.meanings, comment(known.meanings.values()), strict=True))
    law = javascript.program(recorded_law(design), RESERVED["js"])
    values = {"name": code.c_name(design), "known": known, "meanings": meanings, "law": law}
    return rendered("javascript.mjs.j2", design, connection=design.connected, **values)


M = "a function of MATLAB and Octave with the controller, including adaptation"
JS = "a module of JavaScript (ES) with the controller, including adaptation"
FORMATS = (
    Format("m", M, function, ".m", called=True, connects=True),
    Format("js", JS, module, ".mjs", called=True, connects=True),
)
