"""The hand-written loop of c_loop.c, built with gcc into a temporary directory."""

import ctypes
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from work import Work

FLAGS = ("-O3", "-march=native", "-ffast-math", "-fopenmp")
WIDE = "-mprefer-vector-width=512"


def prepare(work: Work, flags: tuple[str, ...] = ()) -> Callable[[], np.ndarray]:
    """A function that scores all individuals, (individuals,); ``flags`` go to gcc as well."""
    library = _built(flags)
    found = np.empty(work.kp.size, np.float32)
    sizes = ctypes.c_int(work.kp.size), ctypes.c_int(work.reference.size)
    arrays = [ctypes.c_void_p(array.ctypes.data) for array in (*work, found)]

    def run() -> np.ndarray:
        library.scores(*sizes, *arrays)
        return found

    return run


def _built(flags: tuple[str, ...]) -> ctypes.CDLL:
    source = Path(__file__).with_name("c_loop.c")
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "c_loop.so"
        command = ["gcc", *FLAGS, *flags, "-shared", "-fPIC", source, "-o", target, "-lm"]
        subprocess.run(command, check=True)
        return ctypes.CDLL(str(target))  # stays mapped when the file is gone
