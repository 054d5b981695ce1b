"""Readers of other programs' fuzzy controllers: a design that a search can start from.

Within the ranges of the file's inputs the design computes what the file says, to rounding. Beyond
them, where programs differ, its outermost terms stay 1. Nothing is approximated: what a design
cannot hold is refused.
"""

import hashlib
from collections.abc import Callable
from os.path import isdir
from pathlib import Path

from hfc_design.core.records import UserError
from hfc_design.core.texts import about, content, decoded
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
    ending = ".csv" if isdir(path) else path.suffix.lower()
    if ending not in READERS:
        raise UserError(f"{path}: is neither .fll, .fis nor a folder of .csv tables")
    with about(path):
        files = csv_tables.files(path) if ending == ".csv" else [path]
        texts, digests = [], {}
        for file in files:
            with about(file):
                found = content(file)
                texts.append(decoded(found))
            digests[file.name] = hashlib.sha256(found).hexdigest()
        return design_of(READERS[ending](*texts), wish, path, digests)
