"""Logs as MAT files of version 5, which MATLAB writes with -v6 and -v7; only numbers are read.

The format is that of MathWorks, "MAT-File Format" (R2024a), chapter 1. SciPy is not used, because
there a damaged file may end the process or take all memory. Every length in a file is checked
against the actual size of the data before it is used.
"""

import struct
import zlib
from collections.abc import Iterator
from math import prod
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from hfc_design.logs.columns import MOST_BYTES, MOST_NUMBERS, Log, longest

#: First bytes of files of MATLAB 7.3, which are HDF5.
NEWER = b"\x89HDF", b"MATLAB 7.3 MAT-file"
#: Offset of the data; last bytes before the data in little-endian and in big-endian files.
HEAD, LITTLE, BIG = 128, b"\0\1IM", b"\1\0MI"
#: Kinds of elements: containers; numbers, with types of NumPy; texts, with their encodings.
MATRIX, COMPRESSED = 14, 15
TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
LETTERS = {1: "latin-1", 2: "utf-8", 4: "utf-16", 16: "utf-8", 17: "utf-16", 18: "utf-32"}
#: Classes of matrices; those from 6 to 15 are numbers.
CELL, STRUCT, OBJECT, TEXT, SPARSE, OPAQUE = 1, 2, 3, 4, 5, 17
KINDS = {CELL: "a cell array", OBJECT: "an object", SPARSE: "sparse"}
COMPLEX = 0x800
#: Largest number of elements of a file, and largest depth of nesting.
MOST_PARTS, DEEPEST = 20_000, 16

Element: TypeAlias = tuple[int, memoryview]


class Numbers(NamedTuple):
    """A matrix of numbers, stored column by column."""

    shape: tuple[int, ...]
    values: np.ndarray  # (prod(shape),)

    @property
    def is_vector(self) -> bool:
        """True if it is a vector of at least two numbers; a scalar is a setting, not a signal."""
        return 1 < prod(self.shape) == max(self.shape)


def mat_log(data: bytes) -> Log:
    """Return the longest vectors of a MAT file as a log, including those in structs.

    Raises:
        ValueError: the data are not a MAT file, are of another version, or contain no vector.
    """
    if data.startswith(NEWER):
        raise ValueError("is of MATLAB 7.3; save it with -v7")
    if len(data) >= 20 and 0 in data[:4]:  # a file of version 5 begins with a text
        raise ValueError("is of MATLAB 4, or not a MAT file; save it with -v7")
    values, others = dict[str, Numbers](), dict[str, str]()
    try:
        for variable, value in _Reader(data).variables():
            if isinstance(value, str):
                others[variable] = "a text" if isinstance(value, Text) else value
            for name, matrix in _signals(variable, value).items():
                known = values.get(name)
                other = known is not None and not np.array_equal(known.values, matrix.values)
                values[f"{variable}.{name}" if other else name] = matrix
    except Exception as error:  # zlib, NumPy and codecs have errors of their own
        why = str(error)[:200] or "it is damaged"
        raise ValueError(f"is not a readable MAT file: {why}") from None
    columns = longest({name: matrix.values for name, matrix in values.items()})
    if not columns:
        has = ", ".join(f"{name} is {what}" for name, what in others.items())[:120]
        made = next((name[:20] for name, what in others.items() if what.startswith("an obj")), "")
        how = f"save vectors: {made and f't = {made}.Time; y = {made}.Data; '}save('log.mat', "
        raise ValueError(
            f"must have a vector of numbers{has and f'; {has}'}; {how}'t', 'y', '-v7')"
        )
    return Log(columns, format="MAT", texts=tuple(others))


def _signals(name: str, value: Any) -> dict[str, Numbers]:
    """Return the vectors in a value by name: labels in structs of Simulink, else dotted names."""
    if isinstance(value, Numbers):
        return {name: value} if value.is_vector else {}
    if not isinstance(value, list):
        return {}
    by_name = dict[str, Numbers]()
    for k, record in enumerate(value):
        full_name = name if len(value) == 1 else f"{name}({k + 1})"
        if len(value) == 1 and {"time", "signals"} <= record.keys():  # structure with time
            by_name |= _signals("time", record["time"])
            signals = record["signals"] if isinstance(record["signals"], list) else []
            for j, signal in enumerate(signals):
                label = signal.get("label")
                labelled = isinstance(label, Text) and label.strip() and label not in by_name
                by_name |= _split(
                    str(label) if labelled else f"{name}.signals({j + 1})", signal["values"]
                )
        elif len(value) == 1 and {"Time", "Data"} <= record.keys():  # a timeseries as a struct
            by_name |= _signals("time", record["Time"]) | _split(name, record["Data"])
        else:
            for field, inside in record.items():
                by_name |= _signals(f"{full_name}.{field}", inside)
    return by_name


def _split(name: str, value: Any) -> dict[str, Numbers]:
    """Return the columns of a matrix (samples, signals) by numbered names, or the vector itself."""
    if not isinstance(value, Numbers) or value.is_vector or len(value.shape) != 2:
        return _signals(name, value)
    rows, columns = value.shape
    parts = np.split(value.values, columns) if 0 < columns < rows else []
    return {f"{name}_{k + 1}": Numbers((rows, 1), part) for k, part in enumerate(parts)}


class Text(str):
    """A text variable in the file; a plain str describes a variable that is not read."""


def _next(parts: Iterator[Element]) -> Element:
    if (element := next(parts, None)) is None:
        raise ValueError("an element is missing")
    return element


class _Reader:
    """Reader of the elements of a file, with limits on their total size."""

    def __init__(self, data: bytes):
        order = {LITTLE: "<", BIG: ">"}.get(data[HEAD - 4 : HEAD])
        if order is None:
            raise ValueError("its header is damaged, or of another format")
        self.order, self.data = order, memoryview(data)[HEAD:]
        self.parts, self.bytes, self.count = MOST_PARTS, MOST_BYTES, MOST_NUMBERS

    def variables(self) -> Iterator[tuple[str, Any]]:
        """Yield names and values of the variables, without MATLAB's own, which have no names."""
        for element in self._elements(self.data):
            kind, data = self._inflated(*element) if element[0] == COMPRESSED else element
            if kind != MATRIX:
                raise ValueError(f"an element must be a matrix (got kind {kind})")
            name, value = self._matrix(data, DEEPEST)
            if name:
                yield name, value

    def _inflated(self, _: int, data: memoryview) -> Element:
        """Return the element in the ``data`` of a compressed element."""
        inflater = zlib.decompressobj()
        inside = inflater.decompress(data, self.bytes + 1)
        self.bytes -= len(inside)
        if self.bytes < 0:
            raise ValueError(f"unpacks to more than {MOST_BYTES // 10**6} MB")
        if not inflater.eof:
            raise ValueError("a compressed element is truncated")
        return _next(self._elements(memoryview(inside)))

    def _elements(self, data: memoryview) -> Iterator[Element]:
        """Yield kind and content of consecutive elements."""
        place = 0
        while place < len(data):
            self._counted(1)
            if len(data) - place < 8:
                raise ValueError("is truncated in an element")
            kind, size = struct.unpack(f"{self.order}II", data[place : place + 8])
            begin, end = place + 8, place + 8 + size
            if kind >> 16:  # small element: its first word has the size, the second the content
                kind, size, begin, end = kind & 0xFFFF, kind >> 16, place + 4, place + 8
            if begin + size > min(end, len(data)):
                raise ValueError("an element is longer than its container")
            yield kind, data[begin : begin + size]
            place = end if kind == COMPRESSED or begin < place + 8 else end + -size % 8

    def _counted(self, parts: int) -> None:
        self.parts -= parts
        if self.parts < 0:
            raise ValueError(f"has more than {MOST_PARTS} elements")

    def _numbers(self, element: Element) -> np.ndarray:
        kind, data = element
        if kind not in TYPES:
            raise ValueError(f"an element must be numbers (got kind {kind})")
        numbers = np.frombuffer(data, self.order + TYPES[kind])
        self.count -= len(numbers)
        if self.count < 0:
            raise ValueError(f"unpacks to more than {MOST_NUMBERS} numbers")
        return numbers

    def _text(self, element: Element) -> str:
        kind, data = element
        order = "" if kind not in (4, 17, 18) else "-le" if self.order == "<" else "-be"
        return bytes(data).decode(LETTERS[kind] + order).rstrip("\0")

    def _matrix(self, data: memoryview, deepest: int) -> tuple[str, Any]:
        """Return name and value: numbers, a text, a struct as a list of dicts, else its class."""
        if not deepest:
            raise ValueError(f"structs are nested more than {DEEPEST} deep")
        if not data:
            return "", Numbers((0, 0), np.zeros(0))
        parts = self._elements(data)
        flags = int(self._numbers(_next(parts))[0])
        kind = flags & 0xFF
        if kind == OPAQUE:
            name, _, text = (self._text(_next(parts)) for _ in range(3))
            return name, f"an object of class {text[:40]}"
        shape = tuple(self._numbers(_next(parts)).tolist())
        if len(shape) < 2 or min(shape) < 0:
            raise ValueError(f"a matrix must have two sizes or more (got {shape[:4]})")
        name = self._text(_next(parts))
        if 6 <= kind <= 15 and not flags & COMPLEX:
            values = self._numbers(_next(parts))
            if len(values) != prod(shape):
                raise ValueError(f"{name[:40]} must have as many numbers as declared")
            return name, Numbers(shape, values)
        if kind == TEXT:
            return name, Text(self._text(_next(parts)))
        if kind == STRUCT:
            return name, self._struct(parts, prod(shape), deepest - 1)
        return name, KINDS.get(kind, "complex" if flags & COMPLEX else "no matrix of numbers")

    def _struct(self, parts: Iterator[Element], count: int, deepest: int) -> list[dict[str, Any]]:
        """Return the elements of a struct, each as a dict of its fields."""
        length, joined = int(self._numbers(_next(parts))[0]), bytes(_next(parts)[1])
        self._counted(count)
        if length < 1:
            raise ValueError("a struct must have fields with names")
        names = [joined[k : k + length] for k in range(0, len(joined), length)]
        fields = [name.split(b"\0")[0].decode() for name in names]
        each = (
            {f: self._matrix(_next(parts)[1], deepest)[1] for f in fields} for _ in range(count)
        )
        return [*each]
