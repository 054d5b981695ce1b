"""FuzzyLite Language, for fuzzylite and pyfuzzylite (from version 6)."""

from functools import partial

from hfc_design.formats.fuzzy_files import texts
from hfc_design.formats.writing import Format

TEXT = "a folder with FuzzyLite Language, one engine a unit"
FORMATS = (Format("fll", TEXT, partial(texts, target="fll")),)
