"""Logs as arrays: NumPy's files, and MATLAB's up to version 7 (v5 of the format)."""

import zipfile
from io import BytesIO
from typing import Any

import numpy as np

from hfc_design.core.numbers import Floats
from hfc_design.logs.log import MOST_NUMBERS, Log
from hfc_design.logs.texts import UNNAMED

#: First bytes of a file of MATLAB 7.3, which is HDF5.
HDF5 = b"\x89HDF"


def numpy_log(found: bytes) -> Log:
    """The log in a ``.npy`` (rows, columns; a record array has names) or ``.npz`` file.

    Raises:
        ValueError: it is none, holds objects, or unpacks to too much.
    """
    try:
        unpacked = _unpacked(found)
        if unpacked > 8 * MOST_NUMBERS:
            raise ValueError(f"unpacks to more than {MOST_NUMBERS} numbers")
        loaded: Any = np.load(BytesIO(found), allow_pickle=False)
        if isinstance(loaded, np.ndarray):
            return Log(_columns(_parts(loaded)), format="NumPy")
        return Log(_columns({name: loaded[name] for name in loaded}), format="NumPy")
    except (ValueError, OSError, EOFError, zipfile.BadZipFile, MemoryError) as error:
        raise ValueError(f"is no file of NumPy that can be read: {error}") from None


def _unpacked(found: bytes) -> int:
    """Bytes that an archive becomes; those of another file."""
    if not found.startswith(b"PK"):
        return len(found)
    with zipfile.ZipFile(BytesIO(found)) as packed:
        return sum(item.file_size for item in packed.infolist())


def _parts(array: Any) -> dict[str, Any]:
    """The columns of an array by their names, or by numbers."""
    if array.dtype.names:
        return {name: array[name] for name in array.dtype.names}
    table = np.atleast_2d(array)
    return {UNNAMED.format(k + 1): table[:, k] for k in range(table.shape[1])}


def mat_log(found: bytes) -> Log:
    """The vectors of the longest length in a MAT file.

    Raises:
        ValueError: it is none, or of MATLAB 7.3.
    """
    from scipy import io

    if found.startswith(HDF5) or found[:19] == b"MATLAB 7.3 MAT-file":
        raise ValueError("is of MATLAB 7.3; save it with -v7")
    file: Any = BytesIO(found)  # SciPy takes files, its types name paths alone
    try:
        shapes = io.whosmat(file)
        if sum(int(np.prod(shape)) for _, shape, _ in shapes) > MOST_NUMBERS:
            raise ValueError(f"unpacks to more than {MOST_NUMBERS} numbers")
        wanted = [name for name, _, kind in shapes if kind in NUMERIC]
        file.seek(0)
        arrays = io.loadmat(file, variable_names=wanted)
    except Exception as error:  # of a damaged file SciPy raises whatever it stumbles over
        raise ValueError(f"is no MAT file that can be read: {error}") from None
    return Log(_columns({name: arrays[name] for name in wanted}), format="MAT")


#: Classes of MATLAB that are numbers.
NUMERIC = frozenset(
    {"double", "single", "logical"}
    | {f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)}
)


def _columns(arrays: dict[str, Any]) -> dict[str, Floats]:
    """Real vectors among ``arrays``, of the longest length; a scalar is a setting, no signal."""
    vectors = {
        str(name): np.asarray(array, float).ravel()
        for name, array in arrays.items()
        if array.dtype.kind in "fiub" and array.size == max(array.shape, default=0)
    }
    longest = max(map(len, vectors.values()), default=0)
    return {name: vector for name, vector in vectors.items() if len(vector) == longest}
