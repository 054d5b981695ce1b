"""Channels of files that libraries read: a program, ``libraries.py KIND MOST WIDEST``, for a file.

A damaged or forged file may end the process of such a library, keep it busy for ever or make it
take all memory. So ``reading.py`` starts this program for each file, with the file on stdin. It
writes a line of JSON and the numbers of the channels, and imports nothing of this package.
"""

import json
import sys
from collections.abc import Iterable, Iterator
from contextlib import suppress
from io import BytesIO
from math import prod
from typing import Any, NamedTuple

import numpy as np

#: Most memory of this process [bytes], where the system limits it.
MEMORY = 4 * 10**9
#: Conversions of raw numbers that in neither MDF 4 (cc_type) nor MDF 3 are formulas or texts.
PLAIN = {0, 1, 2, 4, 5, 6, 9, 65535}
#: Attributes of a data set of HDF5 that have its unit.
UNITS = ("unit", "units", "Unit", "Units")
#: Most columns of a matrix that is a table of signals.
WIDEST = 100


class Channel(NamedTuple):
    """A channel of a file."""

    group: str  # channels of a group have the same times; their length where nothing tells them
    name: str
    path: str  # longer than the name, and distinct
    unit: str  # "": not known; if there are no values, what the channel is instead of numbers
    values: np.ndarray | None  # (rows,)
    sample_time: float | None = None  # [s]


def mdf(file: BytesIO, most: int) -> Iterator[Channel]:
    """Yield the channels of an ASAM MDF file of version 3 or 4, with ``time`` for each group."""
    from asammdf import MDF

    if not file.getvalue().startswith((b"MDF", b"UnFinMF")):  # a zip would be unpacked to the disk
        raise ValueError("it does not begin with MDF")
    log = MDF(file, process_bus_logging=False)
    _check(most, (len(one.channels) * one.channel_group.cycles_nr for one in log.groups))
    for k, group in enumerate(log.groups):
        master = log.masters_db.get(k, -1)
        can = [getattr(one.conversion, "conversion_type", 0) in PLAIN for one in group.channels]
        read = [j for j, one in enumerate(can) if one and (master < 0 or can[master])]
        read = [j for j in read if j != master]
        # ``select`` makes up what an incomplete file lacks; ``get``, which is slow, does not.
        if read:
            first = log.get(group=k, index=read[0], raw=True, ignore_invalidation_bits=True)
            if master >= 0 and getattr(group.channels[master], "sync_type", 1) == 1:
                yield Channel(str(k), "time", "time", "s", first.timestamps)
        chosen = [(None, k, j) for j in read]
        signals = log.select(chosen, copy_master=False, ignore_value2text_conversions=True)
        for j, one in zip(read, signals, strict=True):
            values = one.samples[: len(first.timestamps)]
            if one.invalidation_bits is not None and values.dtype.kind in "fiub":
                values = np.where(one.invalidation_bits[: len(values)], np.nan, values)
            yield Channel(str(k), one.name, f"{one.name}.{j}", one.unit, values)
        for j in {*range(len(can))} - {*read, master}:
            yield Channel("", group.channels[j].name, "", "computed by a formula", None)


def numpy(file: BytesIO, most: int) -> Iterator[Channel]:
    """Yield the arrays of a file .npz, or the columns of one .npy; those of a record have names."""
    loaded = np.load(file, allow_pickle=False)
    if not isinstance(loaded, np.ndarray):
        _check(most, (member.file_size // 8 for member in loaded.zip.infolist()))
    elif loaded.dtype.names:
        loaded = {name: loaded[name] for name in loaded.dtype.names}
    else:
        loaded = {"column_1" if loaded.size == max(loaded.shape, default=0) else "column": loaded}
    for name in loaded:
        yield from _of_value(name, name, loaded[name])


def tdms(file: BytesIO, most: int) -> Iterator[Channel]:
    """Yield the channels of a TDMS file of NI; times since the first one in place of dates."""
    from nptdms import TdmsFile

    with TdmsFile.open(file) as log:
        channels = [one for group in log.groups() for one in group.channels()]
        _check(most, map(len, channels))
        for one in channels:
            properties, values, unit = one.properties, one[:], one.properties.get("unit_string", "")
            clock = [properties.get(f"wf_{x}") for x in ("increment", "start_offset", "start_time")]
            step = clock[0] if properties.get("wf_xunit_string", "") in ("", "s") else None
            group = f"{len(one)} {clock if step else one.group_name}"
            if values.dtype.kind == "M":
                values, unit = (values - values[:1]) / np.timedelta64(1, "s"), "s"
            yield Channel(group, one.name, f"{one.group_name}.{one.name}", unit, values, step)


def hdf5(file: BytesIO, most: int) -> Iterator[Channel]:
    """Yield vectors, columns of matrices and fields of tables of an HDF5 file.

    Data that are in other files, to which this one only refers, are not read.
    """
    import h5py

    items = dict[str, Any]()
    with h5py.File(file, "r") as log:
        log.visititems(lambda path, item: items.update({path: item}))
        sets = {path: item for path, item in items.items() if isinstance(item, h5py.Dataset)}
        inside = {x: y for x, y in sets.items() if not (y.is_virtual or y.external or x[0] == "#")}
        _check(most, (y.size * len(y.dtype.names or "x") for y in inside.values()))
        for path, item in inside.items():
            *_, name = path.split("/")
            unit = next((item.attrs[x] for x in UNITS if x in item.attrs), "")
            unit = unit.decode() if isinstance(unit, bytes) else str(unit)
            char = item.attrs.get("MATLAB_class", b"") in (b"char", b"cell")
            values = np.zeros(0, "O") if char or item.dtype.kind in "OSU" else item[()]
            parts = {f".{x}": values[x] for x in values.dtype.names or ()} or _split(values)
            for end, part in parts.items():
                length = str(part.size)
                yield Channel(length, name + end, path.replace("/", ".") + end, unit, part)


def _split(values: np.ndarray) -> dict[str, np.ndarray]:
    """Return columns of a table of signals by numbered ends of their names, else all by ""."""
    table = values.reshape([size for size in values.shape if size != 1])
    if table.ndim != 2 or table.dtype.kind not in "fiub" or min(table.shape) > WIDEST:
        return {"": values}
    columns = table if len(table) < table.shape[1] else table.T
    return {f"_{k}": column for k, column in enumerate(columns, 1)}


def mat(file: Any, most: int) -> Iterator[Channel]:
    """Yield vectors and columns of a MAT file (not of 7.3), also those in structs."""
    from scipy.io import loadmat, whosmat

    with suppress(TypeError):  # SciPy cannot tell the size of an object
        _check(most, (prod(shape) for _, shape, _ in whosmat(file)))
    for variable, value in loadmat(file, simplify_cells=True).items():
        channels = _of_value(variable, variable, value) if variable[:2] != "__" else ()
        yield from (one for one in channels if not one.unit or "." not in one.path)


def _of_value(name: str, path: str, value: Any) -> Iterator[Channel]:
    """Yield the vectors in a value: named as in structs of Simulink, else by dotted names."""
    if isinstance(value, list) and value and all(isinstance(x, dict) for x in value):
        value = {f"({k})": one for k, one in enumerate(value, 1)}
    if not isinstance(value, dict):
        array = np.zeros(0, "O") if isinstance(value, list) else np.asarray(value)
        what = {"U": "a text", "O": "a cell array", "c": "complex"}.get(array.dtype.kind, "")
        if type(value).__name__ == "MatlabOpaque":
            name, _, kind = (x.decode() for x in value.reshape(-1)[0].tolist()[:3])
            what = f"an object of class {kind[:40]}"
        for end, part in _split(array).items():
            yield Channel(str(part.size), name + end, path + end, what, part)
        return
    parts = {f"{name}{'.' * (field[0] != '(')}{field}": one for field, one in value.items()}
    if {"time", "signals"} <= value.keys():  # structure with time
        parts, signals = {"time": value["time"]}, value["signals"]
        for k, one in enumerate(signals if isinstance(signals, list) else [signals], 1):
            label = one.get("label")
            label = label.strip() if isinstance(label, str) else ""
            parts[label or f"{name}.signals({k})"] = one["values"]
    elif {"Time", "Data"} <= value.keys():  # a timeseries as a struct
        parts = {"time": value["Time"], name: value["Data"]}
    for called, one in parts.items():
        yield from _of_value(called, f"{path}.{called.removeprefix(f'{path}.')}", one)


def _check(most: int, sizes: Iterable[int], what: str = "numbers") -> None:
    """Check what a file declares, before memory is reserved for it."""
    if sum(sizes) > most:
        raise ValueError(f"it has more than {most} {what}")


def main(kind: str, most: str, widest: str) -> None:
    """Write the channels of the file on stdin, or the reason why they cannot be read."""
    out, sys.stdout = sys.stdout.buffer, sys.stderr  # libraries may print
    parts, count = list[np.ndarray](), 0
    head: dict[str, Any] = {"channels": [], "others": []}
    try:
        with suppress(ImportError, OSError, ValueError):  # Windows and macOS have no such limit
            import resource

            resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        reader = {"NumPy": numpy, "MDF": mdf, "TDMS": tdms, "HDF5": hdf5, "MAT": mat}[kind]
        for one in reader(BytesIO(sys.stdin.buffer.read()), int(most)):
            values = one.values
            if values is None or values.dtype.kind not in "fiub":
                head["others"].append([one.name, one.unit])
            elif 1 < values.size == max(values.shape):  # a scalar is a setting, not a signal
                count += values.size
                _check(int(most), [count])
                parts.append(np.asarray(values, np.float64).ravel())
                head["channels"].append([*one[:4], one.sample_time, values.size])
        _check(int(widest), [len(parts)], "signals")
    except Exception as error:  # a library may raise anything
        why = f"it needs more than {MEMORY / 1e9:g} GB" if isinstance(error, MemoryError) else ""
        why = "it holds objects, which are not read" if "pickle" in str(error) else why
        head, parts = {"error": why or str(error) or type(error).__name__}, []
    out.write(json.dumps(head).encode() + b"\n")
    for part in parts:
        out.write(part.tobytes())
    out.flush()


if __name__ == "__main__":
    main(*sys.argv[1:])
