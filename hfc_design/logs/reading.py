"""Selection of the reader of a log by its file; files that only libraries read."""

import json
import os
import subprocess
import sys
from collections import defaultdict
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from hfc_design.core.numbers import Floats, Json
from hfc_design.core.records import harmless
from hfc_design.core.texts import as_user_error, content, decoded
from hfc_design.logs.columns import LARGEST_LOG, MOST_COLUMNS, MOST_NUMBERS, Log, check_log, joined
from hfc_design.logs.scopes import TWINCAT, sinumerik_log, twincat_log
from hfc_design.logs.texts import text_log, with_unit

#: Suffixes of files that libraries read, with their kinds; kind -> library.
KINDS = {".npy": "NumPy", ".npz": "NumPy", ".mat": "MAT", ".h5": "HDF5", ".hdf5": "HDF5"}
KINDS |= {".mf4": "MDF", ".mdf": "MDF", ".tdms": "TDMS"}
PACKAGES = {"NumPy": "numpy", "MAT": "scipy", "HDF5": "h5py", "MDF": "asammdf", "TDMS": "nptdms"}
#: First bytes of files of MATLAB 7.3, which are HDF5.
NEWER = b"\x89HDF", b"MATLAB 7.3 MAT-file"
#: Suffixes of files that only the maker's program reads -> how it writes a table.
NOT_READ = dict.fromkeys((".svd", ".svdx", ".svb", ".svbx"), "TwinCAT's Scope exports them to CSV")
NOT_READ |= dict.fromkeys((".ttrec", ".ttrecx"), "the TIA Portal exports measurements as *.csv")
#: Longest time that a library may take for a file [s].
LONGEST = 60


def read_log(path: str | Path) -> Log:
    """Return the log in a file of any supported format; UserError: why it is none, and where."""
    suffix = Path(path).suffix.lower()
    with as_user_error(path):
        if advice := NOT_READ.get(suffix):
            raise ValueError(f"files {suffix} are not read; {advice}")
        data = content(path, LARGEST_LOG)
        if kind := KINDS.get(suffix):
            newer = kind == "MAT" and data.startswith(NEWER)
            return check_log(library_log("HDF5" if newer else kind, data))
        text = decoded(data, "utf-8-sig")
        if text.lstrip().startswith("<"):
            return check_log(sinumerik_log(text))
        scope = TWINCAT.match(text)
        return check_log(twincat_log(text, scope[1]) if scope else text_log(text))


def library_log(kind: str, data: bytes) -> Log:
    """Return the log in the content of a file; each group of channels has its own times.

    Raises:
        ValueError: the library is not installed, cannot read the data, or finds no signals.
    """
    package, program = PACKAGES[kind], Path(__file__).with_name("libraries.py")
    if find_spec(package) is None:
        raise ValueError(f"needs {package}; pip install 'hfc-design[logs]'")
    command = [sys.executable, "-P", str(program), kind, str(MOST_NUMBERS), str(MOST_COLUMNS)]
    try:
        done = subprocess.run(
            command, input=data, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
            timeout=LONGEST, check=False, env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        raise ValueError(f"cannot be read: {package} takes more than {LONGEST} s") from None
    line, _, numbers = done.stdout.partition(b"\n")
    head: Json = json.loads(line) if done.returncode == 0 else {"error": "it is damaged"}
    if why := head.get("error"):
        raise ValueError(f"is not a readable {kind} file: {why[:200]}")
    if not head["channels"]:
        raise ValueError(_nothing(head["others"], kind))
    empty = Log({}, None, None, kind, tuple(harmless(name[:100]) for name, _ in head["others"]))
    return joined(_groups(head["channels"], np.frombuffer(numbers), empty))


def _groups(channels: list[list[Any]], numbers: Floats, empty: Log) -> list[Log]:
    """Return the channels of each group as a log; names of several channels become paths."""
    groups = defaultdict[str, dict[str, dict[str, tuple[str, Floats]]]](dict)
    steps, begin = dict[str, float | None](), 0
    for group, name, path, unit, step, size in channels:
        values, begin = numbers[begin : begin + size], begin + size
        column, whole = (harmless(with_unit(x[:100], unit[:40])) for x in (name, path))
        same, steps[group] = groups[group].setdefault(name, {}), step
        if not any(np.array_equal(x, values) for _, x in same.values()):  # as times of two structs
            same[whole] = column, values
    logs = list[Log]()
    for group, named in groups.items():
        columns = dict[str, Floats]()
        for same in named.values():
            columns |= {x if len(same) == 1 else y: z for y, (x, z) in same.items()}
        logs.append(empty._replace(columns=columns, sample_time=steps[group]))
    return logs


def _nothing(others: list[list[str]], kind: str) -> str:
    """Return the message for a file without signals."""
    has = "".join(f"; {name} is {what}" for name, what in others if what)[:120]
    made = next((name[:20] for name, what in others if what.startswith("an obj")), "")
    how = f"; save vectors: {made and f't = {made}.Time; y = {made}.Data; '}"
    how = f"{how}save('log.mat', 't', 'y', '-v7')" if kind == "MAT" else ""
    return f"must have a vector of numbers{has}{how}"
