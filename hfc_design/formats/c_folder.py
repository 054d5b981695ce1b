"""``--to c``: a design in C99, and all one needs to flash it."""

from hfc_design.files.design import Design
from hfc_design.formats import machine_code
from hfc_design.formats.flash.folder import with_check
from hfc_design.formats.writing import Content, Format


def folder(design: Design) -> Content:
    """The sources of a design, its page, its vectors, and ``make check``.

    Raises:
        UserError: a kind has no C code, or an input is called like a word of the language.
    """
    return with_check(design, machine_code.sources(design))


C = "a folder with the controller in C99, adaptation and all, a page on it and make check"
FORMATS = (Format("c", C, folder),)
