"""``--to st``: a design as a function block, and all one needs to trust it."""

from hfc_design.files.design import Design
from hfc_design.formats import code
from hfc_design.formats.flash.folder import page_of_axes
from hfc_design.formats.flash.plc import with_vectors
from hfc_design.formats.writing import Content, Format


def folder(design: Design) -> Content:
    """The function block of a design, its page, its vectors, and a program that runs them.

    Raises:
        UserError: the kind has no such code, or a name is none of the language.
    """
    return with_vectors(design, {f"{code.c_name(design)}.st": code.block(design)})


ST = "a folder with a function block in Structured Text (IEC 61131-3), a page on it and its check"
FORMATS = (Format("st", ST, folder, beside=page_of_axes),)
