"""FuzzyLite Language, for fuzzylite and pyfuzzylite (from version 6)."""

from functools import partial

from hfc_design.formats.format import Format
from hfc_design.formats.fuzzy_files import write

TEXT = "a folder with FuzzyLite Language, one engine a unit"
FORMATS = (Format("fll", TEXT, partial(write, target="fll")),)
