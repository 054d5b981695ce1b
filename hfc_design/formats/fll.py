"""FuzzyLite Language, for fuzzylite and pyfuzzylite (from version 6)."""

from pathlib import Path

from hfc_design.files.design import Design
from hfc_design.formats.format import Format
from hfc_design.formats.fuzzy_files import write as write_files

RESERVED = {
    *("if", "is", "then", "and", "or", "with", "inf", "nan", "none", "all", "true", "false"),
    *("any", "not", "extremely", "seldom", "somewhat", "very"),
}


def write(design: Design, path: Path) -> None:
    """Write a folder with one engine a unit.

    Raises:
        UserError: the design has no rule tables, or a name is a word of the language.
        RunError: the folder cannot be written.
    """
    write_files(design, path, "fll", "fll", RESERVED)


FORMATS = (Format("fll", "a folder with FuzzyLite Language, one engine a unit", write),)
