"""``--to c``: a design in C99, and all one needs to flash it."""

from pathlib import Path

from hfc_design.files.design import Design
from hfc_design.formats import code, machine_code
from hfc_design.formats.flash.folder import of_axes, with_check
from hfc_design.formats.writing import Content, Format, signal_units, write


def folder(design: Design) -> Content:
    """The sources of a design, its page, its vectors, and ``make check``.

    Raises:
        UserError: a kind has no C code, or an input is called like a word of the language.
    """
    return with_check(design, machine_code.sources(design))


def write_lookup(design: Design, path: Path, points: int) -> str:
    """Write the same without ``exp``, with degrees tabulated at ``points`` values.

    Returns:
        What deviates most from what is exact, and by how much: the command with its unit, or a
        factor in it.

    Raises:
        UserError: the controller has no terms with an exponential; or as ``folder``.
        RunError: the folder ``path`` cannot be written.
    """
    files, values = code.tabulated(design, points)
    of = values.get("deviates", "command")
    told = f"{of}: {values['deviation']:.2g} {signal_units(design).get(of, '')}".rstrip()
    law = values["law"](design.limits.of(design.axis).command)
    note = f"Its terms are tabulated at {points} values: largest deviation from the exact {told}."
    write(path, with_check(design, files, law, note))
    return told


C = "a folder with the controller in C99, adaptation and all, a page on it and make check"
FORMATS = (Format("c", C, folder, beside=of_axes),)
