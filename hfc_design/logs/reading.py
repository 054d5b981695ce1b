"""Which reader a file is for."""

from pathlib import Path

from hfc_design.core.texts import about, content, decoded
from hfc_design.logs.arrays import numpy_log
from hfc_design.logs.log import LARGEST_LOG, Log, checked
from hfc_design.logs.mat import mat_log
from hfc_design.logs.texts import text_log

#: Endings of files that are no text.
ARRAYS = {".mat": mat_log, ".npy": numpy_log, ".npz": numpy_log}


def read_log(path: str | Path) -> Log:
    """What a machine has recorded, whoever wrote it down.

    Raises:
        UserError: it cannot be read, or is no log; the line says why and where.
    """
    with about(path):
        found = content(path, LARGEST_LOG)
        if reader := ARRAYS.get(Path(path).suffix.lower()):
            return checked(reader(found))
        return checked(text_log(decoded(found, "utf-8-sig")))
