"""Runs a law on nodes, which write down what it does: the functions that a law gets as ``xp``."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import reduce
from inspect import signature
from operator import add
from typing import Any

import numpy as np

from hfc_design.codegen.nodes import (
    REAL,
    WHOLE,
    Array,
    Assign,
    Block,
    Branch,
    Call,
    Each,
    Function,
    Lazy,
    Loop,
    Node,
    Put,
    Storage,
    Store,
    Stored,
    flat,
    kind_of,
    refusal,
)
from hfc_design.codegen.sayings import call_it, first_line, unnamed
from hfc_design.codegen.simplify import known, simpler, value_of
from hfc_design.codegen.values import (
    begin_of,
    cost,
    form_of,
    given_of,
    mapped,
    numbers_in,
    row_of,
    several,
    shape_of,
    type_of,
)
from hfc_design.core.numbers import SCALARS, Xp

#: More operations than a law has that comes to an end.
MOST = 100_000
#: Sums of no more operations are written out.
SHORT = 24


class Trace:
    """What one function does: that of a whole law, or one that it calls."""

    def __init__(self, whole: "Trace | None" = None, in_place: bool = False, flat: bool = False):
        self.whole: Trace = whole or self
        #: Whether what a law calls is recorded where it is called, for languages without functions.
        self.flat = flat
        #: Whether what is remembered may be written to before the law is through.
        self.in_place = in_place
        self.root = self.block = Block(self)
        self.running: Trace = self  # of the whole: that of the function that is being recorded
        self.count = 0
        self.functions: dict[object, Function] = {}  # of the whole
        self.tables: dict[object, Storage] = {}  # of the whole, in the order of their use
        self.bound: set[Node] = set()  # what is computed before it is stored
        self.sure: set[Node] = set()  # what is finite
        self.assigned: dict[Node, list[Any]] = {}  # of the whole: what variables may be
        self.rewritten: set[Storage] = set()  # of the arrays that are remembered

    # Numbers.

    def made(self, op: str, *args: Any) -> Any:
        """The node of an operation; equal ones are one."""
        args = tuple(map(self.plain, args))
        if (found := simpler(op, args)) is not None:
            return found
        key = (op, *(x if isinstance(x, Node) else (type(x), x) for x in args))
        block = self._deepest(args)
        at: Block | None = block
        while at is not None:
            if key in at.known:
                return at.known[key]
            at = at.around
        node = self._node(block, op, args, type_of(op, args))
        block.known[key] = node
        block.items.append(node)
        node.value = value_of(op, args)
        return node

    def plain(self, value: Any) -> Any:
        """A node, or a number as Python has it."""
        if isinstance(value, Node):
            return value
        if isinstance(value, bool | np.bool_):
            return bool(value)
        if isinstance(value, int | np.integer):
            return int(value)
        if isinstance(value, float | np.floating):
            return float(value)
        raise refusal(f"computes with {value!r:.60}, which is no number")

    def leaf(self, op: str, name: str, kind: str = REAL, value: float | None = None) -> Node:
        """A number from outside: an input, what is remembered, a number of the design."""
        node = self._node(self.root, op, (), kind)
        node.name, node.value = name, value
        return node

    def _node(self, block: Block, op: str, args: tuple[Any, ...], kind: str) -> Node:
        self.whole.count += 1
        if self.whole.count > MOST:
            raise refusal(f"takes more than {MOST} operations: does a loop not end?")
        return Node(block, op, args, kind, self.whole.count)

    def _deepest(self, args: Sequence[Any]) -> Block:
        """The outermost block in which all of these are known; none leaves a branch."""
        found = self.block
        while not found.branch and found.around is not None:
            found = found.around
        for x in args:
            if isinstance(x, Node):
                if not self._around(x.block):
                    raise refusal("uses a value outside the loop or the function that it is of")
                found = x.block if x.block.depth > found.depth else found
        return found

    def _around(self, block: Block) -> bool:
        at: Block | None = self.block
        while at is not None and at is not block:
            at = at.around
        return at is block

    # Arrays.

    def read(self, storage: Storage, place: Any) -> Any:
        """A number in memory."""
        args = (self.plain(place),)
        fixed = storage.kind in ("table", "parameter")
        block = self._deepest(args) if fixed else self.block
        key = ("read", storage, storage.version, *args)
        at: Block | None = self.block
        while at is not None:
            if key in at.known:
                return at.known[key]
            at = at.around
        node = self._node(block, "read", (storage, *args), storage.type)
        block.known[key] = node
        block.items.append(node)
        if storage.kind == "table" and isinstance(place, int):
            node.value = storage.numbers[place]
        return node

    def store(self, storage: Storage, place: Any, value: Any) -> None:
        """Write a number."""
        self.block.items.append(Store(storage, self.plain(place), self.plain(value)))

    def table(self, rows: Any, name: str = "") -> Any:
        """Numbers as an array that values can index."""
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
            found = Storage("table", name, shape, kind)
            found.numbers = [x if kind != REAL else float(x) for x in values]
            self.whole.tables[key] = found
        found = self.whole.tables[key]
        found.name = found.name or name
        return Stored(self, found)

    def local(self, shape: tuple[int, ...], numbers: Sequence[Any], name: str = "") -> Stored:
        """An array of these numbers within a sample."""
        storage = Storage("local", name, shape)
        self.block.items.append(storage)
        for k, x in enumerate(numbers):
            self.store(storage, k, x)
        return Stored(self, storage)

    def write(self, put: Put) -> Stored:
        """Replace numbers of an array, in its place or in that of a copy."""
        storage = self._own(put.base)
        for place, value in put.changes:
            self.store(storage, place, value)
        return self._since(storage)

    def _own(self, array: Stored) -> Storage:
        """The memory of an array that may be written to; a copy of what is remembered, else."""
        storage = array.storage
        if storage.kind == "local" or (storage.kind != "table" and self.in_place):
            array.flat(0)  # or it is no more what it was
            return storage
        copy = self.local(array.shape, ())
        self.replace([(copy.storage, array)])
        return copy.storage

    def _since(self, storage: Storage) -> Stored:
        storage.version += 1
        self.rewritten.add(storage)
        return Stored(self, storage)

    # What a law finds in xp.

    @property
    def xp(self) -> Xp:
        """The functions of a law."""
        return SCALARS._replace(
            where=lambda condition, a, b: self.made("?", condition, a, b),
            minimum=lambda a, b: self.made("min", a, b),
            maximum=lambda a, b: self.made("max", a, b),
            bell=lambda rate, distance: self.made("exp", (-rate * distance) * distance),
            tanh=lambda x: self.made("tanh", x),
            sqrt=lambda x: self.made("sqrt", x),
            floor=lambda x: self.made("floor", x),
            foreign=self.foreign,
            ratio=lambda a, b: self.made("/", a, b),
            stored=self.stored,
            pick=self.pick,
            sparse=True,
            along=self.along,
            each=self.each,
            total=self.total,
            table=self.table,
            whole=lambda x: self.made("whole", x),
            put=self.put,
            between=self.between,
            sure=self.marked,
            when=self.when,
            call=self.call,
        )

    def foreign(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """What a function gives that may be written for JAX."""
        from hfc_design.codegen.jaxprs import traced  # which starts it

        with unnamed():
            return traced(self, function, *arguments)

    def stored(self, value: Any) -> Any:
        """An array that is computed here, and not again wherever it is read."""
        if not isinstance(value, Lazy | Each):
            return value
        found = self.local(value.shape, ())
        self.replace([(found.storage, value)])
        found.storage.version += 1
        return Stored(self, found.storage)

    def replace(self, pairs: Sequence[tuple[Storage, Any]], *places: Any) -> None:
        """Write all numbers of several arrays of one shape, of each place together."""
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

    def pick(self, values: Any, number: Any) -> Any:
        """The value of a number that is one of the design."""
        if isinstance(number, Node) and number.value is None:
            raise refusal("picks by a number that is known at run time alone")
        return values[int(number)]

    def marked(self, x: Any) -> Any:
        """What is finite, whatever comes."""
        self.sure |= {x} if isinstance(x, Node) else set()
        return x

    def between(
        self,
        tables: Sequence[Any],
        low: Any,
        high: Any,
        function: Callable[..., Any],
        but: int | None = None,
    ) -> list[Stored]:
        """Tables of which some rows became ``function(number, row, ...)``, ``but`` one."""
        owned = [self._own(self._stored(table)) for table in tables]
        count = owned[0].shape[0]
        low, high = self.made("max", low, 0), self.made("min", high, count)
        with self.loop(high, low) as k, self._unless(but, k):
            after = function(k, *(Stored(self, one)[k] for one in owned))
            self._at([*zip(owned, after, strict=True)], k)
        return [*map(self._since, owned)]

    def _stored(self, table: Any) -> Stored:
        base = self.table(table)
        if isinstance(base, Put):
            base.flat(0)  # which writes it
            base = base.written
        return base

    @contextmanager
    def _unless(self, but: int | None, k: Node) -> Iterator[None]:
        if but is None:
            yield
            return
        inner = self.block
        condition = self.made("!=", k, but)
        self.block = Block(self, inner, branch=True)
        yield
        inner.items.append(Branch(condition, self.block))
        self.block = inner

    @contextmanager
    def loop(self, high: Any, low: Any = 0) -> Iterator[Node]:
        """Record what is done with an index."""
        block = Block(self, self.block)
        index = self._node(block, "index", (), WHOLE)
        self.block = block
        yield index
        assert block.around is not None
        self.block = block.around
        self.block.items.append(Loop(index, low, high, block))

    def along(self, function: Callable[..., Any], *rows: Any) -> Any:
        """``function`` of what stands at the same place in rows: lazy where one is an array."""
        if not any(isinstance(row, Array | range) for row in rows):
            return [function(*values) for values in zip(*rows, strict=True)]
        if len({len(row) for row in rows}) > 1:
            raise refusal("goes along rows of different lengths")
        rows = tuple(row if isinstance(row, Array | range) else self.table(row) for row in rows)
        of = [(lambda k: k) if isinstance(row, range) else row.__getitem__ for row in rows]

        def at(k: Any) -> Any:
            return function(*(get(k) for get in of))

        first, mark = at(0), len(self.block.items)
        del self.block.items[mark:]
        return Lazy(self, (len(rows[0]), *shape_of(first)), at)

    def each(self, function: Callable[..., Any], *tables: Any) -> Any:
        """``function`` of what stands at the same place in tables, computed where it is used."""
        return Each(self, function, [self.table(table) for table in tables])

    def total(self, values: Any) -> Any:
        """The sum, from left to right."""
        if not isinstance(values, Array):
            return reduce(add, values)
        first = values[0]
        if len(values) * cost(first) <= SHORT:
            return reduce(add, values)
        variable = self._node(self.block, "variable", (), REAL)
        self.block.items.append(Assign(variable, 0.0, True))
        with self.loop(len(values)) as k:
            self.block.items.append(Assign(variable, variable + values[k], False))
        return variable if isinstance(first, Node) else reduce(add, values)

    def put(self, rows: Any, changes: Sequence[tuple[Any, ...]]) -> Any:
        """Rows with some numbers replaced: ``(place, ..., value)`` of each."""
        found = self.stored(self.table(rows))
        if isinstance(found, Put):
            found.element((0,) * len(found.shape))
            found = found.written
        return Put(found, [(flat(one[:-1], found.shape), self.plain(one[-1])) for one in changes])

    def when(self, condition: Any, function: Callable[[], Any], otherwise: Any) -> Any:
        """``function()`` where the condition is true, else ``otherwise``."""
        if not isinstance(condition, Node):
            return function() if condition else otherwise
        if isinstance(otherwise, Node | float) and self._idle(function, otherwise):
            return otherwise
        holders = mapped(self._holder, otherwise)
        block = Block(self, self.block, branch=True)
        self.block = block
        mapped(self._hold, holders, function())
        assert block.around is not None
        self.block = block.around
        self.block.items.append(Branch(condition, block))
        return mapped(lambda one: self._since(one) if isinstance(one, Storage) else one, holders)

    def _idle(self, function: Callable[[], Any], otherwise: Node | float) -> bool:
        """Whether a function gives the number ``otherwise``; what it does is dropped."""
        around = self.block
        self.block = Block(self, around, branch=True)
        found = function()
        self.block = around
        if isinstance(found, Node) or isinstance(otherwise, Node):
            return found is otherwise
        return bool(found == otherwise)

    def _holder(self, value: Any) -> Any:
        """What has the value before a branch and after it."""
        if isinstance(value, Array):
            array = self._stored(value)
            return array if array.storage.kind == "table" else self._own(array)
        value = self.plain(value)
        if known(value) is not None and isinstance(value, Node):
            return value  # a number of the design, which no branch changes
        return self.variable(value)

    def variable(self, value: Any) -> Node:
        """What has the value until it is assigned another one."""
        found = self._node(self.block, "variable", (), kind_of(value))
        self.whole.assigned[found] = [value]
        self.block.items.append(Assign(found, value, True))
        return found

    def now(self, variable: Node) -> Node:
        """What a variable is here, whatever it is assigned later."""
        found = self._node(self.block, "now", (variable,), variable.type)
        self.block.items.append(found)
        self.bound.add(found)
        return found

    def assign(self, variable: Node, value: Any) -> None:
        """Give a variable another value."""
        self.whole.assigned[variable].append(self.plain(value))
        self.block.items.append(Assign(variable, self.plain(value), False))

    def _hold(self, holder: Any, value: Any) -> None:
        if isinstance(holder, Node) and holder.op == "variable":
            self.assign(holder, value)
        elif isinstance(holder, Storage) and self._stored(value).storage is not holder:
            self.replace([(holder, self._stored(value))])

    def call(self, function: Callable[..., Any], xp: Xp, *args: Any) -> Any:
        """``function(xp, *args)`` as a function of the code.

        Of its arguments tuples of numbers are these, lists are arrays. It may give a number, a
        tuple of numbers, a list of numbers, which is an array, or tables of its arguments that it
        has changed.
        """
        args = tuple(map(self._argument, args))
        if self.flat:
            for wish, x in zip([*signature(function).parameters][1:], args, strict=True):
                call_it(x, wish) if isinstance(x, Stored) else None
            return self._given_back(function(self.xp, *args))
        key = (function, *map(form_of, args))
        if key not in self.whole.functions:
            self.whole.functions[key] = self._recorded(function, args)
        called = self.whole.functions[key]
        stored, given = {}, []
        for x, parameter in zip(given_of(args), called.parameters, strict=True):
            if isinstance(x, Stored):
                x.storage.name = x.storage.name or parameter.name
            if isinstance(parameter, Storage) and parameter.version:
                stored[parameter] = self._own(self._stored(x))
                given.append((stored[parameter], 0))
            else:
                given.append(begin_of(x) if isinstance(x, Array) else x)
        return self._called(called, tuple(given), stored)

    def _called(
        self, called: Function, given: tuple[Any, ...], stored: dict[Storage, Storage]
    ) -> Any:
        results: list[Any] = []
        for x in called.results:
            if isinstance(x, Storage):
                results.append(Storage("local", "", x.shape))
                self.block.items.append(results[-1])
            else:
                results.append(self._node(self.block, "called", (), kind_of(x)))
        self.block.items.append(Call(called, given, (*results, *stored.values())))
        found = iter(results)
        since = {parameter: self._since(storage) for parameter, storage in stored.items()}

        def outside(value: Any) -> Any:
            """What a caller sees of what the function made."""
            if isinstance(value, Stored) and value.storage in since:
                return since[value.storage]
            if isinstance(value, tuple):
                parts = map(outside, value)
                return type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)
            if isinstance(value, Stored):
                return value  # a table
            one = next(found)
            if isinstance(one, Storage):
                one.version += 1
                return Stored(self, one)
            return one

        return outside(called.made)

    def _argument(self, x: Any) -> Any:
        return self.stored(self.table(x)) if isinstance(x, Array | list) else x

    def _given_back(self, value: Any) -> Any:
        if not isinstance(value, tuple):
            return self._argument(value)
        parts = map(self._given_back, value)
        return type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)

    def _recorded(self, function: Callable[..., Any], args: tuple[Any, ...]) -> Function:
        inner = Trace(self.whole, in_place=True)
        found = Function(function.__name__.strip("_"), inner)
        wishes = [*signature(function).parameters][1:]

        def parameter(wish: str, x: Any) -> Any:
            """What the function sees of an argument."""
            if isinstance(x, Array):
                storage = Storage("parameter", wish, x.shape, begin_of(x)[0].type)
                found.parameters.append(storage)
                return Stored(inner, storage)
            if isinstance(x, Node):
                found.parameters.append(inner.leaf("parameter", wish, x.type))
                return found.parameters[-1]
            if several(x):
                return tuple(parameter(f"{wish}_{k}", one) for k, one in enumerate(x))
            return x

        given = [parameter(wish, x) for wish, x in zip(wishes, args, strict=True)]
        outer, self.whole.running = self.whole.running, inner
        found.made = function(inner.xp, *given)
        self.whole.running = outer
        found.what = first_line(function.__code__)
        self._results(found, found.made)
        return found

    def _results(self, found: Function, value: Any) -> None:
        if isinstance(value, tuple):
            for one in value:
                self._results(found, one)
        elif isinstance(value, Stored) and value.storage.kind != "local":
            return  # it is there already
        elif isinstance(value, Array | list):
            filled = Storage("result", "result", shape_of(value))
            found.trace.replace([(filled, value)])
            found.results.append(filled)
        else:
            found.results.append(found.trace.plain(value))


def _straight(values: Any) -> bool:
    """Whether numbers can be computed one after the other, as they lie in memory."""
    if isinstance(values, Each):
        return all(map(_straight, values.tables))
    return isinstance(values, Stored)
