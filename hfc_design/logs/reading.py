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
from hfc_design.logs.mat import mat_log
from hfc_design.logs.texts import UNNAMED, text_log


def read_log(path: str | Path) -> Log:
    """Return the log in a file of any supported format.

    Raises:
        UserError: the file cannot be read, or is not a log; the message says why, and where.
    """
    with as_user_error(path):
        data = content(path, LARGEST_LOG)
        if reader := ARRAYS.get(Path(path).suffix.lower()):
            return check_log(reader(data))
        return check_log(text_log(decoded(data, "utf-8-sig")))


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


#: Suffixes of files that are not text.
ARRAYS = {".mat": mat_log, ".npy": numpy_log, ".npz": numpy_log}
