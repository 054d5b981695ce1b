"""Writers of a design for other programs: one function a format, a dict of them."""

from collections.abc import Callable
from pathlib import Path

from hfc_design.export import csv_tables, fcl, fll, fml, json_file
from hfc_design.rulebase import Design

#: Format -> (what it writes, writer). A writer takes a design and a path that does not exist.
FORMATS: dict[str, tuple[str, Callable[[Design, Path], None]]] = {
    "json": ("the design file itself", json_file.write),
    "csv": ("a folder with one labelled rule table a unit, and manifest.csv", csv_tables.write),
    "fll": ("a folder with FuzzyLite Language, one engine a unit", fll.write),
    "fcl": ("a folder with Fuzzy Control Language of IEC 61131-7, one block a unit", fcl.write),
    "fcl-jfuzzylogic": ("the same in the dialect of jFuzzyLogic", fcl.write_jfuzzylogic),
    "fml": ("a folder with Fuzzy Markup Language (IEEE 1855), one system a unit", fml.write),
}
