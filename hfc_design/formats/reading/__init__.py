"""Readers of other programs' fuzzy controllers: a design that a search can start from.

Within the ranges of the file's inputs the design computes what the file says, to rounding. Beyond
them, where programs differ, its outermost terms stay 1. Nothing is approximated: what a design
cannot hold is refused.
"""

import hashlib
from collections.abc import Callable
from pathlib import Path

from hfc_design.core.checkpoint import read_text
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.formats.reading import csv_tables, fis, fll
from hfc_design.formats.reading.design_of import Wish, design_of
from hfc_design.formats.reading.system import System

__all__ = ["READERS", "Wish", "imported"]

#: Ending of a file -> its reader. Tables (.csv, or a folder) are several files.
READERS: dict[str, Callable[..., System]] = {
    ".fll": fll.read,
    ".fis": fis.read,
    ".csv": csv_tables.read,
}


def imported(path: Path, wish: Wish) -> Design:
    """The design in the file or folder ``path``, with what ``wish`` adds to it.

    Raises:
        UserError: the file cannot be read, or holds more or less than a design can.
    """
    ending = ".csv" if path.is_dir() else path.suffix.lower()
    if ending not in READERS:
        raise UserError(f"{path}: is neither .fll, .fis nor a folder of .csv tables")
    try:
        files = csv_tables.files(path) if ending == ".csv" else [path]
        system = READERS[ending](*map(read_text, files))
        digests = {file.name: hashlib.sha256(file.read_bytes()).hexdigest() for file in files}
        return design_of(system, wish, path, digests)
    except ValueError as error:
        raise UserError(f"{path}: {error}") from None
