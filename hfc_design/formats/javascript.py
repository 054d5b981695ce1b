"""``--to js``: a design as a module of JavaScript, for a page that simulates or for Node."""

from hfc_design.codegen.javascript import program
from hfc_design.controllers.kind import needed
from hfc_design.files.design import Design
from hfc_design.formats import code
from hfc_design.formats.laws import recorded_law
from hfc_design.formats.writing import (
    RESERVED,
    Format,
    comment,
    rendered,
    signal_meanings,
    signal_units,
)


def module(design: Design) -> str:
    """An ES module with ``initial()`` and ``step(state, inputs, limit)``.

    Raises:
        UserError: the kind is none of an axis, or a law does what no code can be made of.
    """
    needed(design.kind.law, design, "it commands a whole machine; --to c has its code")
    code.checked_numbers(design)
    told = signal_meanings(design)
    change = design.changes([design.axis])[design.axis]
    values = {
        "name": code.c_name(design),
        "signals": code.signals(design),
        "meanings": dict(zip(told, comment(told.values()), strict=True)),
        "command_unit": signal_units(design).get("command", "unit"),
        "law": program(recorded_law(design.controller, change), RESERVED["js"]),
    }
    return rendered("javascript.mjs.j2", design, **values)


JS = "a module of JavaScript (ES) with the controller, adaptation and all"
FORMATS = (Format("js", JS, module, suffix=".mjs"),)
