"""Execution of a law on nodes, with functions ``xp`` that record the operations of the law."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import reduce
from inspect import signature
from operator import add
from typing import Any

from hfc_design.codegen.jaxprs import traced
from hfc_design.codegen.nodes import (
    REAL,
    Array,
    Assign,
    Branch,
    Call,
    Each,
    Function,
    Lazy,
    Node,
    Put,
    Storage,
    Stored,
    flat,
    kind_of,
    refusal,
)
from hfc_design.codegen.recorder import Recorder
from hfc_design.codegen.sayings import call_it, first_line, profiled
from hfc_design.codegen.simplify import known
from hfc_design.codegen.values import begin_of, cost, form_of, given_of, mapped, several, shape_of
from hfc_design.core.numbers import SCALARS, Xp

#: Largest number of operations of a sum that is written out; longer sums become loops.
SHORT = 24


class Trace(Recorder):
    """Recording of one function, for a law that runs with its ``xp``."""

    @property
    def xp(self) -> Xp:
        """Functions for a law that record what the law does."""
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
        """Return the result of a function that may be written for JAX."""
        with profiled(None):
            return traced(self, function, *arguments)

    def pick(self, values: Any, number: Any) -> Any:
        """Return the element of ``values`` with a number that is known before run time."""
        if isinstance(number, Node) and number.value is None:
            raise refusal("selects by a number that is known only at run time")
        return values[int(number)]

    def marked(self, x: Any) -> Any:
        """Mark a number as finite whatever its operands are, and return it."""
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
        """Set rows ``low`` to ``high`` - 1 except ``but`` to ``function(number, row, ...)``."""
        owned = [self._writable(self._stored(table)) for table in tables]
        count = owned[0].shape[0]
        low, high = self.made("max", low, 0), self.made("min", high, count)
        with self.loop(high, low) as k, self._unless(but, k):
            after = function(k, *(Stored(self, one)[k] for one in owned))
            self._at([*zip(owned, after, strict=True)], k)
        return [*map(self._since, owned)]

    @contextmanager
    def _unless(self, but: int | None, k: Node) -> Iterator[None]:
        if but is None:
            yield
            return
        condition = self.made("!=", k, but)
        with self.inside(branch=True) as block:
            yield
        self.block.items.append(Branch(condition, block))

    def along(self, function: Callable[..., Any], *rows: Any) -> Any:
        """Apply ``function`` to rows, index by index; ``Lazy`` if one is an array or a range."""
        if not any(isinstance(row, Array | range) for row in rows):
            return [function(*values) for values in zip(*rows, strict=True)]
        if len({len(row) for row in rows}) > 1:
            raise refusal("iterates over rows of different lengths")
        rows = tuple(row if isinstance(row, Array | range) else self.table(row) for row in rows)
        of = [(lambda k: k) if isinstance(row, range) else row.__getitem__ for row in rows]

        def at(k: Any) -> Any:
            return function(*(get(k) for get in of))

        first, mark = at(0), len(self.block.items)
        del self.block.items[mark:]
        return Lazy(self, (len(rows[0]), *shape_of(first)), at)

    def each(self, function: Callable[..., Any], *tables: Any) -> Any:
        """Return ``Each``: results of ``function`` at each index of tables, computed where used."""
        return Each(self, function, [self.table(table) for table in tables])

    def total(self, values: Any) -> Any:
        """Return the sum of ``values``, added from left to right."""
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
        """Return rows with some numbers replaced, each change as ``(place, ..., value)``."""
        storage = self.stored(self.table(rows))
        if isinstance(storage, Put):
            storage.element((0,) * len(storage.shape))
            storage = storage.written
        return Put(
            storage, [(flat(one[:-1], storage.shape), self.plain(one[-1])) for one in changes]
        )

    def when(self, condition: Any, function: Callable[[], Any], otherwise: Any) -> Any:
        """Return ``function()`` if the condition is true, else ``otherwise``."""
        if not isinstance(condition, Node):
            return function() if condition else otherwise
        if isinstance(otherwise, Node | float) and self._idle(function, otherwise):
            return otherwise
        holders = mapped(self._holder, otherwise)
        with self.inside(branch=True) as block:
            mapped(self._hold, holders, function())
        self.block.items.append(Branch(condition, block))
        return mapped(lambda one: self._since(one) if isinstance(one, Storage) else one, holders)

    def _idle(self, function: Callable[[], Any], otherwise: Node | float) -> bool:
        """True if a function returns the number ``otherwise``; this call of it is not recorded."""
        with self.inside(branch=True):
            result = function()
        if isinstance(result, Node) or isinstance(otherwise, Node):
            return result is otherwise
        return bool(result == otherwise)

    def _holder(self, value: Any) -> Any:
        """Return a variable with the value before a branch, for the value after the branch."""
        if isinstance(value, Array):
            array = self._stored(value)
            return array if array.storage.kind == "table" else self._writable(array)
        value = self.plain(value)
        if known(value) is not None and isinstance(value, Node):
            return value  # a number of the design, which no branch changes
        return self.variable(value)

    def _hold(self, holder: Any, value: Any) -> None:
        if isinstance(holder, Node) and holder.op == "variable":
            self.assign(holder, value)
        elif isinstance(holder, Storage) and self._stored(value).storage is not holder:
            self.replace([(holder, self._stored(value))])

    def call(self, function: Callable[..., Any], xp: Xp, *args: Any) -> Any:
        """Record ``function(xp, *args)`` as a call of a function in the code.

        In ``args``, tuples of numbers remain tuples, and lists become arrays. The function may
        return a number, a tuple of numbers, a list of numbers (an array), or tables among its
        arguments that it has changed.
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
                stored[parameter] = self._writable(self._stored(x))
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
        results_left = iter(results)
        since = {parameter: self._since(storage) for parameter, storage in stored.items()}

        def outside(value: Any) -> Any:
            """Return the caller's view of a result."""
            if isinstance(value, Stored) and value.storage in since:
                return since[value.storage]
            if isinstance(value, tuple):
                parts = map(outside, value)
                return type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)
            if isinstance(value, Stored):
                return value  # a table
            one = next(results_left)
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
        recorded = Function(function.__name__.strip("_"), inner)
        wishes = [*signature(function).parameters][1:]

        def parameter(wish: str, x: Any) -> Any:
            """Return the function's view of an argument."""
            if isinstance(x, Array):
                storage = Storage("parameter", wish, x.shape, begin_of(x)[0].type)
                recorded.parameters.append(storage)
                return Stored(inner, storage)
            if isinstance(x, Node):
                recorded.parameters.append(inner.leaf("parameter", wish, x.type))
                return recorded.parameters[-1]
            if several(x):
                return tuple(parameter(f"{wish}_{k}", one) for k, one in enumerate(x))
            return x

        given = [parameter(wish, x) for wish, x in zip(wishes, args, strict=True)]
        outer, self.whole.running = self.whole.running, inner
        recorded.made = function(inner.xp, *given)
        self.whole.running = outer
        recorded.what = first_line(function.__code__)
        self._results(recorded, recorded.made)
        return recorded

    def _results(self, recorded: Function, value: Any) -> None:
        if isinstance(value, tuple):
            for one in value:
                self._results(recorded, one)
        elif isinstance(value, Stored) and value.storage.kind != "local":
            return  # the caller has it already
        elif isinstance(value, Array | list):
            filled = Storage("result", "result", shape_of(value))
            recorded.trace.replace([(filled, value)])
            recorded.results.append(filled)
        else:
            recorded.results.append(recorded.trace.plain(value))
