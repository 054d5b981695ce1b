"""Elements of a recorded law: numbers, arrays, and statements in blocks. Never imports JAX.

Equal expressions are one node, in the outermost block in which all their operands are known. Arrays
are stored row after row, because every language has arrays of one dimension.
"""

import math
import traceback
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple, Protocol, TypeAlias

from hfc_design.core.records import UserError

#: Types of numbers.
REAL, WHOLE, TRUTH = "real", "whole", "truth"
#: Operations that return a truth value.
TRUTHS = frozenset(("<", "<=", ">", ">=", "==", "!=", "and", "or", "not"))
#: Folders of files that contain no lines of a law.
INNER = (str(Path(__file__).parent), str(Path(__file__).parents[1] / "core"))


class TraceError(UserError):
    """Error: a law for which no code can be generated; it begins with the law's file and line."""

    placed = False

    def at(self, place: str) -> "TraceError":
        """Return the error with its ``place``, FILE:LINE, unless it already has one."""
        if self.placed or not place:
            return self
        located = TraceError(f"{place}: {self}")
        located.placed = True
        return located


def refusal(what: str) -> TraceError:
    """Return the error about the line that is being recorded; ``what`` describes what it does."""
    for frame in reversed(traceback.extract_stack()):
        if not frame.filename.startswith(INNER):
            return TraceError(what).at(f"{frame.filename}:{frame.lineno}")
    return TraceError(what)


class Tape(Protocol):
    """Recording that nodes and arrays belong to: a ``recorder.Recorder``."""

    running: Any  # recording of the function that runs now
    block: Any
    bound: set["Node"]

    def made(self, op: str, *args: Any) -> Any:
        """Return the node of an operation."""

    def read(self, storage: "Storage", place: Any) -> "Node":
        """Return the node of a number of an array in memory, from its index."""

    def write(self, put: Any) -> Any:
        """Write the changes of a ``Put``, and return the array after them."""


class Block:
    """Nodes and statements in order; the block of a loop or a branch is inside another one."""

    def __init__(self, trace: "Tape", around: "Block | None" = None, branch: bool = False):
        self.trace, self.around, self.branch = trace, around, branch
        self.depth: int = 0 if around is None else around.depth + 1
        self.items: list[Any] = []  # nodes, arrays that are declared, statements
        self.known: dict[object, Node] = {}

    def outward(self) -> "Iterator[Block]":
        """Yield this block and the blocks around it, the nearest first."""
        at: Block | None = self
        while at is not None:
            yield at
            at = at.around


def _operator(op: str) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """Return two methods of ``Node`` for an operator: with the node at the left, at the right."""
    return (
        lambda self, other: self.block.trace.made(op, self, other),
        lambda self, other: self.block.trace.made(op, other, self),
    )


class Node:
    """Number or truth value that the code computes."""

    __slots__ = ("args", "block", "name", "number", "op", "type", "value")

    def __init__(self, block: Block, op: str, args: tuple[Any, ...], kind: str, number: int):
        self.block, self.op, self.args, self.type, self.number = block, op, args, kind, number
        self.name = ""
        #: Value of a number that is known before run time, such as one of a design; else None.
        self.value: float | bool | None = None

    def __repr__(self) -> str:
        return f"<{self.name or self.op} {self.number}>"

    __add__, __radd__ = _operator("+")
    __sub__, __rsub__ = _operator("-")
    __mul__, __rmul__ = _operator("*")
    __truediv__, __rtruediv__ = _operator("/")
    __and__, __rand__ = _operator("and")
    __or__, __ror__ = _operator("or")
    __lt__, __gt__ = _operator("<")[0], _operator(">")[0]
    __le__, __ge__ = _operator("<=")[0], _operator(">=")[0]
    __eq__, __ne__ = _operator("==")[0], _operator("!=")[0]

    def __neg__(self) -> "Node":
        return self.block.trace.made("neg", self)

    def __abs__(self) -> "Node":
        return self.block.trace.made("abs", self)

    def __pow__(self, power: Any) -> "Node":
        if power != 0.5:
            raise refusal(
                f"raises a value to the power of {power!r}; write a product, or ** 0.5 for a "
                "square root"
            )
        return self.block.trace.made("sqrt", self)

    def __invert__(self) -> "Node":
        return self.block.trace.made("not", self)

    def __hash__(self) -> int:
        return self.number

    def __bool__(self) -> bool:
        if self.value is None:
            raise refusal(
                "branches on a value that is known only at run time; write "
                "xp.where(condition, a, b) instead"
            )
        return bool(self.value)

    def __float__(self) -> float:
        if self.value is None:
            raise refusal(
                "needs the number of a value that is known only at run time, as "
                "functions of math do; write it with + - * /, abs and the functions of "
                "xp instead"
            )
        return float(self.value)

    def __index__(self) -> int:
        return int(float(self))

    def __iter__(self) -> Iterator["Node"]:
        raise refusal("uses a number as a sequence of numbers")


class Storage:
    """Array in memory: numbers one after the other, under one name."""

    def __init__(self, kind: str, name: str, shape: tuple[int, ...], type_: str = REAL):
        self.kind = kind  # table, state, local, parameter or result
        self.name, self.shape, self.type = name, shape, type_
        self.numbers: list[float] = []  # values, if it is a table
        self.version = 0  # number of times that it was changed

    @property
    def size(self) -> int:
        """Number of values."""
        return math.prod(self.shape)


class Array:
    """Sequence of numbers or of rows, as a law sees it."""

    trace: "Tape"
    shape: tuple[int, ...]

    def element(self, places: tuple[Any, ...]) -> Any:
        """Return the number at an index for each dimension."""
        return self.flat(flat(places, self.shape))

    def flat(self, place: Any) -> Any:
        """Return the number at an index in memory, counted row after row."""
        raise NotImplementedError

    def __len__(self) -> int:
        return self.shape[0]

    def __iter__(self) -> Iterator[Any]:
        return (self[k] for k in range(len(self)))

    def __getitem__(self, place: Any) -> Any:
        if isinstance(place, slice):
            places = range(len(self))[place]
            step, begin = places.step, places.start
            shape = (len(places), *self.shape[1:])
            return Lazy(self.trace, shape, lambda k: self[k * step + begin])
        if isinstance(place, int):
            if not -len(self) <= place < len(self):
                raise IndexError(place)  # ends a loop of Python over it
            place %= len(self)
        return self.element((place,)) if len(self.shape) == 1 else Row(self, place)


class Row(Array):
    """Row of an array."""

    def __init__(self, whole: Any, place: Any):
        self.whole, self.place = whole, place
        self.trace, self.shape = whole.trace, whole.shape[1:]

    def flat(self, place: Any) -> Any:
        """Return the number at an index in memory, counted from the beginning of the row."""
        return self.whole.flat(self.place * math.prod(self.shape) + place)

    def element(self, places: tuple[Any, ...]) -> Any:
        """Return the number at an index for each dimension of the row."""
        return self.whole.element((self.place, *places))


class Stored(Array):
    """Array in memory, as it is when this object is made; reads after a later write are refused."""

    def __init__(self, trace: "Tape", storage: Storage):
        self.trace, self.storage, self.shape = trace, storage, storage.shape
        self.version = storage.version

    def flat(self, place: Any) -> Any:
        """Return the number at an index in memory."""
        if self.version != self.storage.version:
            raise refusal(f"reads numbers of {self.storage.name} after it has replaced some")
        return self.trace.read(self.storage, place)


class Lazy(Array):
    """Array whose numbers are computed where they are used."""

    def __init__(self, trace: "Tape", shape: tuple[int, ...], function: Callable[[Any], Any]):
        self.trace, self.shape, self.function = trace, shape, function

    def element(self, places: tuple[Any, ...]) -> Any:
        """Return the number at an index for each dimension, a result of the function."""
        value = self.function(places[0])
        for place in places[1:]:
            value = value[place]
        return value


class Each(Array):
    """Array of the results of a function for the numbers at the same index of several arrays."""

    def __init__(self, trace: "Tape", function: Callable[..., Any], tables: list[Any]):
        self.trace, self.shape, self.function = trace, tables[0].shape, function
        if any(table.shape != self.shape for table in tables):
            raise refusal("iterates over tables of different sizes")
        self.tables = tables

    def element(self, places: tuple[Any, ...]) -> Any:
        """Return the result of the function for the numbers at an index."""
        return self.function(*(table.element(places) for table in self.tables))

    def flat(self, place: Any) -> Any:
        """Return the number at an index in memory."""
        return self.function(*(table.flat(place) for table in self.tables))


class Put(Array):
    """Array in memory with some numbers replaced, which is done when it is read or at the end."""

    def __init__(self, base: Stored, changes: list[tuple[Any, Any]]):
        self.base, self.changes = base, changes  # changes: (index in memory, new number)
        self.trace, self.shape = base.trace, base.shape
        self.written: Stored | None = None

    def flat(self, place: Any) -> Any:
        """Return the number at an index in memory."""
        if self.written is None:
            self.written = self.trace.write(self)
        return self.written.flat(place)


def flat(places: tuple[Any, ...], shape: tuple[int, ...]) -> Any:
    """Return the index in memory of the number at ``places``, an index for each dimension."""
    index = places[0]
    for place, size in zip(places[1:], shape[1:], strict=True):
        index = index * size + place
    return index


class Comment(NamedTuple):
    """Comment before some statements: the first paragraph of a docstring of the law."""

    text: str


class Loop(NamedTuple):
    """Loop that runs a block with ``counter`` from ``low`` to ``high`` - 1."""

    counter: Node
    low: Any
    high: Any
    block: Block


class Branch(NamedTuple):
    """Branch that runs a block if ``condition`` is true."""

    condition: Node
    block: Block


class Assign(NamedTuple):
    """Assignment of a value to a variable; ``first`` marks its first value."""

    variable: Node
    value: Any
    first: bool


class Store(NamedTuple):
    """Write of a number to an array, or to a single number in memory."""

    storage: "Storage | Node"  # an array, or the node of a single number in memory
    place: Any
    value: Any


class Call(NamedTuple):
    """Call of a function that returns numbers, fills an array or replaces some numbers."""

    function: "Function"
    args: tuple[Any, ...]  # nodes and numbers; for an array (its storage, its first index)
    results: tuple[Node | Storage, ...]


Statement: TypeAlias = Comment | Loop | Branch | Assign | Store | Call


class Function:
    """Function that a law calls with numbers and arrays, as a function in the code."""

    def __init__(self, name: str, trace: Any):
        self.name, self.trace = name, trace
        self.what = ""  # first paragraph of its docstring, for a comment
        self.parameters: list[Node | Storage] = []
        self.results: list[Any] = []  # numbers; for an array the storage that is filled
        self.made: Any = None  # what the law's function returned when it was recorded


def kind_of(x: Any) -> str:
    """Return the type of a number, a truth value or an array, of a law or of Python."""
    if isinstance(x, Node | Storage):
        return x.type
    return TRUTH if isinstance(x, bool) else WHOLE if isinstance(x, int) else REAL
