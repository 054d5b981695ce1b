"""Selection of the reader of a log by its file, and the reader of NumPy's files."""

from pathlib import Path

import numpy as np

from hfc_design.core import archive
from hfc_design.core.texts import as_user_error, content, decoded
from hfc_design.logs.columns import (
    LARGEST_LOG,
    MOST_BYTES,
    MOST_COLUMNS,
    Log,
    check_log,
    longest,
)
from hfc_design.logs.foreign import library_log
from hfc_design.logs.scopes import TWINCAT, sinumerik_log, twincat_log
from hfc_design.logs.texts import UNNAMED, text_log


def read_log(path: str | Path) -> Log:
    """Return the log in a file of any supported format.

    Raises:
        UserError: the file cannot be read, or is not a log; the message says why, and where.
    """
    suffix = Path(path).suffix.lower()
    with as_user_error(path):
        if advice := NOT_READ.get(suffix):
            raise ValueError(f"files {suffix} are not read; {advice}")
        data = content(path, LARGEST_LOG)
        if suffix in (".npy", ".npz"):
            return check_log(numpy_log(data))
        if kind := KINDS.get(suffix):
            return check_log(library_log(kind, data))
        text = decoded(data, "utf-8-sig")
        if text.lstrip().startswith("<"):
            return check_log(sinumerik_log(text))
        if scope := TWINCAT.match(text):
            return check_log(twincat_log(text, scope[1]))
        return check_log(text_log(text))


def numpy_log(data: bytes) -> Log:
    """Return the log in a ``.npy`` file (rows, columns; a record array has names) or ``.npz`` file.

    Raises:
        ValueError: the data are not such a file, contain objects, or are too large when unpacked.
    """
    try:
        if data.startswith(b"PK"):
            arrays = archive.arrays(data, MOST_BYTES, archive.DEFLATED)
        else:
            arrays = _parts(archive.array_of(data))
        return Log(longest({str(x): y for x, y in arrays.items() if _is_signal(y)}), format="NumPy")
    except Exception as error:  # zipfile raises errors of any kind for a damaged file
        why = str(error)[:200] or "it is damaged"
        raise ValueError(f"is not a readable NumPy file: {why}") from None


def _is_signal(array: np.ndarray) -> bool:
    """Return True for a vector of real numbers; a scalar is a setting, not a signal."""
    return array.dtype.kind in "fiub" and 1 < array.size == max(array.shape, default=0)


def _parts(array: np.ndarray) -> archive.Arrays:
    """Return the columns of an array by name; columns without names are numbered."""
    if array.dtype.names:
        return {name: array[name] for name in array.dtype.names}
    table = array[:, None] if array.ndim == 1 else array
    if table.ndim != 2 or table.shape[1] > MOST_COLUMNS:
        got = f"(got {array.shape[:4]})"
        raise ValueError(f"its array must have rows and at most {MOST_COLUMNS} columns {got}")
    return {UNNAMED.format(k + 1): table[:, k] for k in range(table.shape[1])}


#: Suffixes of files that libraries read.
KINDS = {".mat": "MAT", ".mf4": "MDF", ".mdf": "MDF", ".tdms": "TDMS"}
KINDS |= dict.fromkeys((".h5", ".hdf5"), "HDF5")
#: Suffixes of files of which only the maker's program makes a table -> what to do in it.
NOT_READ = dict.fromkeys((".svd", ".svdx", ".svb", ".svbx"), "in TwinCAT's Scope, export to CSV")
NOT_READ |= dict.fromkeys((".ttrec", ".ttrecx"), "in the TIA Portal, export the measurement as *.csv")
