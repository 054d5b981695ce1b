"""Writers of a design for other programs: one function a format, a dict of them."""

from collections.abc import Callable
from pathlib import Path

from hfc_design.files.design import Design
from hfc_design.formats import (
    c_source,
    csv_tables,
    fcl,
    fis,
    fll,
    fml,
    json_file,
    linuxcnc,
    mat,
    structured_text,
)

#: Format -> (what it writes, writer). A writer takes a design and a path that does not exist.
FORMATS: dict[str, tuple[str, Callable[[Design, Path], None]]] = {
    "json": ("the design file itself", json_file.write),
    "csv": ("a folder with one labelled rule table a unit, and manifest.csv", csv_tables.write),
    "fll": ("a folder with FuzzyLite Language, one engine a unit", fll.write),
    "fcl": ("a folder with Fuzzy Control Language of IEC 61131-7, one block a unit", fcl.write),
    "fcl-jfuzzylogic": ("the same in the dialect of jFuzzyLogic", fcl.write_jfuzzylogic),
    "fml": ("a folder with Fuzzy Markup Language (IEEE 1855), one system a unit", fml.write),
    "c": ("a folder with the controller in C99, adaptation and all", c_source.write),
    "linuxcnc": ("a folder with a HAL component and a simulated machine", linuxcnc.write),
    "fis": ("a folder for MATLAB and Octave, one .fis a unit, and controller.m", fis.write),
    "mat": ("a MAT file with tables, terms, gains and wiring", mat.write),
    "st": ("Structured Text of IEC 61131-3, one function block", structured_text.write),
}
