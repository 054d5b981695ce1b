"""``documentation/index.html`` of an FMU: what other folders say in README.md, as HTML."""

from html import escape

from markdown_it import MarkdownIt

from hfc_design.files.design import Design
from hfc_design.files.pairing import axes_of
from hfc_design.formats.flash import readme
from hfc_design.formats.fmu.control import commands_machine
from hfc_design.formats.fmu.description import Model
from hfc_design.formats.writing import rendered

#: HTML in a text stays text.
MARKDOWN = MarkdownIt("commonmark", {"html": False}).enable("table")


def page(model: Model, design: Design) -> str:
    """The page on a model, the same for every version of FMI."""
    whole = commands_machine(design)
    axes = axes_of(design) if whole or model.part != "controller" else ()
    several = whole or (len(axes) > 1 and not design.axis)
    values = readme.known(design, axes if several else ()) | {"model": model}
    body = MARKDOWN.render(rendered("fmu/index.md.j2", design, **values))
    return rendered("fmu/index.html.j2", design, title=escape(model.name), body=body)
