"""Selection of the reader of a file, and NumPy's own files."""

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
    """The log in a file of any supported format.

    Raises:
        UserError: it cannot be read, or is not a log; the message has the reason and the place.
    """
    with as_user_error(path):
        data = content(path, LARGEST_LOG)
        if reader := ARRAYS.get(Path(path).suffix.lower()):
            return check_log(reader(data))
        return check_log(text_log(decoded(data, "utf-8-sig")))


def numpy_log(data: bytes) -> Log:
    """The log in a ``.npy`` (rows, columns; a record array has names) or ``.npz`` file.

    Raises:
        ValueError: it is not such a file, contains objects, or unpacks to too much.
    """
    try:
        if data.startswith(b"PK"):
            arrays = archive.arrays(data, MOST_BYTES, archive.DEFLATED)
        else:
            arrays = _parts(archive.array_of(data))
        return Log(longest({str(x): y for x, y in arrays.items() if _is_signal(y)}), format="NumPy")
    except Exception as error:  # of a damaged file zipfile raises whatever it stumbles over
        why = str(error)[:200] or "it is damaged"
        raise ValueError(f"is not a readable NumPy file: {why}") from None


def _is_signal(array: np.ndarray) -> bool:
    """True for a vector of real numbers; a scalar is a setting."""
    return array.dtype.kind in "fiub" and 1 < array.size == max(array.shape, default=0)


def _parts(array: np.ndarray) -> archive.Arrays:
    """The columns of an array by their names, or by numbers."""
    if array.dtype.names:
        return {name: array[name] for name in array.dtype.names}
    table = array[:, None] if array.ndim == 1 else array
    if table.ndim != 2 or table.shape[1] > MOST_COLUMNS:
        got = f"(got {array.shape[:4]})"
        raise ValueError(f"its array must have rows and at most {MOST_COLUMNS} columns {got}")
    return {UNNAMED.format(k + 1): table[:, k] for k in range(table.shape[1])}


#: Suffixes of files that are not text.
ARRAYS = {".mat": mat_log, ".npy": numpy_log, ".npz": numpy_log}
