"""Logs in files that only libraries read: MAT, HDF5, ASAM MDF and TDMS of NI."""

import json
import subprocess
import sys
from collections import defaultdict
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from hfc_design.core.numbers import Floats
from hfc_design.core.records import harmless
from hfc_design.logs.columns import MOST_COLUMNS, MOST_NUMBERS, Log, joined
from hfc_design.logs.texts import with_unit

#: First bytes of files of MATLAB 7.3, which are HDF5.
NEWER = b"\x89HDF", b"MATLAB 7.3 MAT-file"
#: Kind -> the library that reads it.
PACKAGES = {"MAT": "scipy", "HDF5": "h5py", "MDF": "asammdf", "TDMS": "nptdms"}
#: Longest time that a library may take for a file [s].
LONGEST = 60


def library_log(kind: str, data: bytes) -> Log:
    """Return the log in the content of a file, of which each group of channels has its own times.

    Raises:
        ValueError: the library is not installed, cannot read the data, or finds no signals.
    """
    kind = "HDF5" if kind == "MAT" and data.startswith(NEWER) else kind
    package = PACKAGES[kind]
    if find_spec(package) is None:
        raise ValueError(f"needs {package}; pip install 'hfc-design[logs]'")
    program = Path(__file__).with_name("libraries.py")  # a process of its own: see there
    command = [sys.executable, "-P", str(program), kind, str(MOST_NUMBERS)]
    try:
        done = subprocess.run(
            command, input=data, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
            timeout=LONGEST, check=False,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        raise ValueError(f"cannot be read: {package} takes more than {LONGEST} s") from None
    line, _, numbers = done.stdout.partition(b"\n")
    head = json.loads(line) if done.returncode == 0 else {"error": "it is damaged"}
    if why := head.get("error"):
        raise ValueError(f"is not a readable {kind} file: {why[:200]}")
    if len(head["channels"]) > MOST_COLUMNS:
        raise ValueError(f"must have at most {MOST_COLUMNS} signals (got {len(head['channels'])})")
    others = tuple(harmless(name[:100]) for name, _ in head["others"])
    groups = _groups(head["channels"], np.frombuffer(numbers))
    logs = [Log(columns, step, format=kind, texts=others) for step, columns in groups]
    if not logs:
        raise ValueError(_nothing(head["others"], kind))
    return joined(logs)


def _groups(channels: list[list], numbers: Floats) -> list[tuple[float | None, dict[str, Floats]]]:
    """Return sample time and columns of each group; where columns share a name, it is a path."""
    groups = defaultdict[str, dict[str, dict[str, tuple[str, Floats]]]](dict)
    steps, begin = dict[str, float | None](), 0
    for group, name, path, unit, step, size in channels:
        values, begin = numbers[begin : begin + size], begin + size
        column, whole = (harmless(with_unit(x[:100], unit[:40])) for x in (name, path))
        same, steps[group] = groups[group].setdefault(name, {}), step
        if not any(np.array_equal(x, values) for _, x in same.values()):  # as times of two structs
            same[whole] = column, values
    return [
        (
            steps[group],
            {
                column if len(same) == 1 else whole: values
                for same in named.values()
                for whole, (column, values) in same.items()
            },
        )
        for group, named in groups.items()
    ]


def _nothing(others: list[list[str]], kind: str) -> str:
    """Return the message for a file without signals."""
    has = ", ".join(f"{name} is {what}" for name, what in others if what)[:120]
    made = next((name[:20] for name, what in others if what.startswith("an obj")), "")
    how = f"; save vectors: {made and f't = {made}.Time; y = {made}.Data; '}"
    how = f"{how}save('log.mat', 't', 'y', '-v7')" if kind == "MAT" else ""
    return f"must have a vector of numbers{has and f'; {has}'}{how}"
