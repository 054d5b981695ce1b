"""Recorder of a law's operations on nodes: numbers, variables, loops, arrays in memory."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from hfc_design.codegen.nodes import (
    REAL,
    WHOLE,
    Array,
    Assign,
    Block,
    Each,
    Function,
    Lazy,
    Loop,
    Node,
    Put,
    Row,
    Storage,
    Store,
    Stored,
    flat,
    kind_of,
    refusal,
)
from hfc_design.codegen.simplify import known, simpler, value_of
from hfc_design.codegen.values import numbers_in, row_of, shape_of, type_of

#: Largest number of operations; a law with more is taken to be endless.
MOST = 100_000


class Recorder:
    """Recording of one function: that of a whole law, or one that the law calls."""

    def __init__(self, whole: "Recorder | None" = None, in_place: bool = False, flat: bool = False):
        self.whole: Any = whole or self
        #: True if called functions are recorded in place, for languages without functions.
        self.flat = flat
        #: True if memory may be written to before the law has finished.
        self.in_place = in_place
        self.root = self.block = Block(self)
        self.running: Any = self  # only in ``whole``: recording of the function that runs now
        self.count = 0
        self.functions: dict[object, Function] = {}  # only in ``whole``
        self.tables: dict[object, Storage] = {}  # only in ``whole``, in the order of their use
        self.bound: set[Node] = set()  # nodes that get a name, so that they are computed in time
        self.sure: set[Node] = set()  # nodes that are finite whatever their operands are
        self.assigned: dict[Node, list[Any]] = {}  # only in ``whole``: variable -> its values
        self.rewritten: set[Storage] = set()  # arrays some of whose numbers were replaced

    def made(self, op: str, *args: Any) -> Any:
        """Return the node of an operation; equal operations are one node."""
        args = tuple(map(self.plain, args))
        if (simple := simpler(op, args)) is not None:
            return simple
        key = (op, *(x if isinstance(x, Node) else (type(x), x) for x in args))
        block = self._deepest(args)
        node, new = self._known(block, block, key, op, args, type_of(op, args))
        if new:
            node.value = value_of(op, args)
        return node

    def _known(
        self, seen: Block, block: Block, key: object, op: str, args: tuple[Any, ...], kind: str
    ) -> tuple[Node, bool]:
        """Return the node of ``key`` known in ``seen``, or a new one in ``block``; True if new."""
        for at in seen.outward():
            if key in at.known:
                return at.known[key], False
        node = self._node(block, op, args, kind)
        block.known[key] = node
        block.items.append(node)
        return node, True

    def plain(self, value: Any) -> Any:
        """Return a node as it is, and a number as a number of Python; others are refused."""
        if isinstance(value, Node):
            return value
        if isinstance(value, bool | np.bool_):
            return bool(value)
        if isinstance(value, int | np.integer):
            return int(value)
        if isinstance(value, float | np.floating):
            return float(value)
        raise refusal(f"computes with {value!r:.60}, which is not a number")

    def leaf(self, op: str, name: str, kind: str = REAL, value: float | None = None) -> Node:
        """Return a number from outside: an input, a number in memory, a number of the design."""
        node = self._node(self.root, op, (), kind)
        node.name, node.value = name, value
        return node

    def _node(self, block: Block, op: str, args: tuple[Any, ...], kind: str) -> Node:
        self.whole.count += 1
        if self.whole.count > MOST:
            raise refusal(f"takes more than {MOST} operations: is a loop endless?")
        return Node(block, op, args, kind, self.whole.count)

    def _deepest(self, args: Sequence[Any]) -> Block:
        """Return the outermost block that knows all ``args``, but none outside of a branch."""
        around = [*self.block.outward()]
        deepest = next((block for block in around if block.branch), around[-1])
        for x in args:
            if isinstance(x, Node):
                if x.block not in around:
                    raise refusal("uses a value outside its loop or function")
                deepest = x.block if x.block.depth > deepest.depth else deepest
        return deepest

    def variable(self, value: Any) -> Node:
        """Return a variable that keeps ``value`` until it is assigned another one."""
        node = self._node(self.block, "variable", (), kind_of(value))
        self.whole.assigned[node] = [value]
        self.block.items.append(Assign(node, value, True))
        return node

    def now(self, variable: Node) -> Node:
        """Return the present value of a variable, whatever is assigned to it later."""
        node = self._node(self.block, "now", (variable,), variable.type)
        self.block.items.append(node)
        self.bound.add(node)
        return node

    def assign(self, variable: Node, value: Any) -> None:
        """Assign another value to a variable."""
        self.whole.assigned[variable].append(self.plain(value))
        self.block.items.append(Assign(variable, self.plain(value), False))

    @contextmanager
    def inside(self, branch: bool = False) -> Iterator[Block]:
        """Record operations in a new inner block."""
        around = self.block
        self.block = Block(self, around, branch)
        yield self.block
        self.block = around

    @contextmanager
    def loop(self, high: Any, low: Any = 0) -> Iterator[Node]:
        """Record operations in a loop over an index."""
        with self.inside() as block:
            index = self._node(block, "index", (), WHOLE)
            yield index
        self.block.items.append(Loop(index, low, high, block))

    def read(self, storage: Storage, place: Any) -> Any:
        """Return the node of a number of an array in memory, from its index."""
        args = (self.plain(place),)
        fixed = storage.kind in ("table", "parameter")
        block = self._deepest(args) if fixed else self.block
        key = ("read", storage, storage.version, *args)
        node, new = self._known(self.block, block, key, "read", (storage, *args), storage.type)
        if new and storage.kind == "table" and isinstance(place, int):
            node.value = storage.numbers[place]
        return node

    def store(self, storage: Storage, place: Any, value: Any) -> None:
        """Record the write of a number to an index of an array in memory."""
        self.block.items.append(Store(storage, self.plain(place), self.plain(value)))

    def table(self, rows: Any, name: str = "") -> Any:
        """Return numbers as an array that nodes can index."""
        if isinstance(rows, Array):
            return rows
        shape = shape_of(rows)
        numbers = [*numbers_in(rows)]
        values: list[Any] = [known(x) for x in numbers]
        if any(x is None for x in values):
            return self.local(shape, numbers, name)
        kinds = {kind_of(x) for x in values}
        kind = kinds.pop() if len(kinds) == 1 else REAL
        key = shape, kind, tuple(values)
        if key not in self.whole.tables:
            storage = Storage("table", name, shape, kind)
            storage.numbers = [x if kind != REAL else float(x) for x in values]
            self.whole.tables[key] = storage
        storage = self.whole.tables[key]
        storage.name = storage.name or name
        return Stored(self, storage)

    def local(self, shape: tuple[int, ...], numbers: Sequence[Any], name: str = "") -> Stored:
        """Return an array with these numbers that exists within a sample."""
        storage = Storage("local", name, shape)
        self.block.items.append(storage)
        for k, x in enumerate(numbers):
            self.store(storage, k, x)
        return Stored(self, storage)

    def write(self, put: Put) -> Stored:
        """Write the changes of a ``Put``, in place or to a copy; return the array after them."""
        storage = self._writable(put.base)
        for place, value in put.changes:
            self.store(storage, place, value)
        return self._since(storage)

    def _writable(self, array: Stored) -> Storage:
        """Return the array's storage if it may be written to now, else that of a copy."""
        storage = array.storage
        if storage.kind == "local" or (storage.kind != "table" and self.in_place):
            array.flat(0)  # refused if it was written to meanwhile
            return storage
        copy = self.local(array.shape, ())
        self.replace([(copy.storage, array)])
        return copy.storage

    def _since(self, storage: Storage) -> Stored:
        storage.version += 1
        self.rewritten.add(storage)
        return Stored(self, storage)

    def stored(self, value: Any) -> Any:
        """Return an array whose numbers are computed once, here; other values as they are."""
        if not isinstance(value, Lazy | Each):
            return value
        storage = self.local(value.shape, ())
        self.replace([(storage.storage, value)])
        storage.storage.version += 1
        return Stored(self, storage.storage)

    def _stored(self, table: Any) -> Stored:
        base = self.table(table)
        if isinstance(base, Put):
            base.flat(0)  # writes its changes
            base = base.written
        return base

    def replace(self, pairs: Sequence[tuple[Storage, Any]], *places: Any) -> None:
        """Write new numbers to arrays of one shape, (storage, numbers) each, index by index."""
        if not places and all(_straight(values) for _, values in pairs):
            with self.loop(pairs[0][0].size) as k:
                self._store(pairs, k, [values.flat(k) for _, values in pairs])
            return
        size = pairs[0][0].shape[len(places)]
        if not isinstance(pairs[0][1], Array):
            for n in range(size):
                self._at([(storage, values[n]) for storage, values in pairs], *places, n)
            return
        with self.loop(size) as k:
            self._at([(storage, row_of(values, k)) for storage, values in pairs], *places, k)

    def _at(self, pairs: Sequence[tuple[Storage, Any]], *places: Any) -> None:
        if len(places) < len(pairs[0][0].shape):
            self.replace(pairs, *places)
            return
        place = flat(places, pairs[0][0].shape)
        self._store(pairs, place, [self.plain(value) for _, value in pairs])

    def _store(self, pairs: Sequence[tuple[Storage, Any]], place: Any, values: list[Any]) -> None:
        self.bound |= {x for x in values if len(pairs) > 1 and isinstance(x, Node)}
        for (storage, _), value in zip(pairs, values, strict=True):
            self.store(storage, place, value)


def _straight(values: Any) -> bool:
    """True if numbers can be read one after the other, in their order in memory."""
    if isinstance(values, Each):
        return all(map(_straight, values.tables))
    return isinstance(values, Stored) or (isinstance(values, Row) and _straight(values.whole))
