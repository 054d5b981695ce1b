"""``--to js``: a design as a module of JavaScript, for a page that simulates or for Node."""

from hfc_design.codegen.javascript import program
from hfc_design.files.design import Design
from hfc_design.formats import code
from hfc_design.formats.laws import recorded_law
from hfc_design.formats.writing import RESERVED, Format, comment, rendered


def module(design: Design) -> str:
    """An ES module with ``initial()`` and ``step(state, inputs, limit)``.

    Raises:
        UserError: what it reads is not known, or a law does what no code can be made of.
    """
    code.checked_numbers(design)
    known = code.flat(design)
    values = {
        "name": code.c_name(design),
        "known": known,
        "connection": design.connected,
        "meanings": dict(zip(known.meanings, comment(known.meanings.values()), strict=True)),
        "law": program(recorded_law(design), RESERVED["js"]),
    }
    return rendered("javascript.mjs.j2", design, **values)


JS = "a module of JavaScript (ES) with the controller, adaptation and all"
FORMATS = (Format("js", JS, module, suffix=".mjs", called=True, connects=True),)
