"""Printer of recorded functions: it decides which numbers get a name and which lines are printed.

How a language writes a number, an operation or a loop is in ``language``; this module is the same
for all languages.
"""

import re
from collections.abc import Iterable, Iterator
from textwrap import wrap
from typing import Any, Protocol

from hfc_design.codegen.live import LEAVES, counted
from hfc_design.codegen.nodes import REAL, WHOLE, Block, Comment, Function, Node, Storage
from hfc_design.codegen.recorder import Recorder

#: Levels of precedence, from the lowest to the highest, and the level of each operation.
CHOICE, OR, AND, EQUAL, ORDER, SUM, PRODUCT, SIGN, ATOM = range(9)
BINDING = {"?": CHOICE, "or": OR, "and": AND, "==": EQUAL, "!=": EQUAL, "+": SUM, "-": SUM}
BINDING |= dict.fromkeys(("<", "<=", ">", ">="), ORDER) | {"*": PRODUCT, "/": PRODUCT}
BINDING |= {"neg": SIGN, "not": SIGN}
WIDTH = 100


class Names:
    """Assignment of unique names to nodes, arrays and functions."""

    def __init__(self, taken: Iterable[str], fold: bool = False, around: "Names | None" = None):
        self.fold, self.around = fold, around
        self.given: dict[object, str] = {}
        self.taken = {self.folded(name) for name in taken}
        self.used: set[object] = set()  # things whose names the text contains

    def of(self, thing: Any, wish: str = "") -> str:
        """Return the name of a thing; tables, functions and numbers have one name everywhere."""
        home = self.around if self.around and _everywhere(thing) else self
        if thing not in home.given:
            name = home.given[thing] = self.fresh(wish or thing.name or "part")
            home.taken.add(self.folded(name))
        return home.given[thing]

    def fresh(self, wish: str) -> str:
        """Return a name that nothing else has: ``wish``, or one that is similar."""
        first = re.sub("_+", "_", re.sub("[^A-Za-z0-9_]", "_", wish)).strip("_") or "part"
        first = first if first[0].isalpha() else f"part_{first}"
        taken = [self.taken, self.around.taken if self.around else ()]
        name, k = first, 1
        while any(self.folded(name) in names for names in taken):
            k += 1
            name = f"{first}_{k}"
        self.taken.add(self.folded(name))
        return name

    def folded(self, name: str) -> str:
        """Return a name as the language compares it: in lower case if it ignores case."""
        return name.casefold() if self.fold else name


def _everywhere(thing: Any) -> bool:
    if isinstance(thing, Storage):
        return thing.kind == "table"
    return isinstance(thing, Function) or (isinstance(thing, Node) and thing.op == "number")


class Syntax(Protocol):
    """Part of ``language.Language`` that a ``Printer`` uses; see the methods there."""

    fold: bool
    chooses: frozenset[str]

    def literal(self, value: float | bool, real: bool) -> str: ...  # noqa: D102
    def comment(self, text: str) -> list[str]: ...  # noqa: D102
    def leaf(self, node: Node, name: str) -> str: ...  # noqa: D102
    def element(self, storage: Storage, name: str, place: str) -> str: ...  # noqa: D102
    def operation(self, op: str, parts: list[str], node: Node) -> str: ...  # noqa: D102
    def statement(self, printer: "Printer", item: Any) -> Iterator[str]: ...  # noqa: D102


class Printer:
    """Printer of one function: it finds the statements that are needed, and prints them."""

    def __init__(
        self, trace: Recorder, syntax: "Syntax", roots: Iterable[Any], around: Names, *others: Block
    ):
        self.trace, self.syntax = trace, syntax
        self.names = Names((), syntax.fold, around)
        self.alive, self.uses = counted(trace, roots, *others)
        self.bound: set[Node] = {*trace.bound}  # they get a name even if they are used once
        self.done: set[Node] = set()  # nodes that were printed already
        self.commented: set[str] = set()  # comments that were printed already

    def inlined(self, node: Node) -> bool:
        """True if a node is printed within the expression that uses it, without a name."""
        if node in self.bound or node.op in self.syntax.chooses:
            return False
        uses = self.uses.get(node, [])
        once = len(uses) == 1 and uses[0] is node.block
        if node.op == "read":
            storage, place = node.args
            if storage.kind in ("table", "parameter") and not storage.version:
                return isinstance(place, int) or once
            if storage in self.trace.rewritten:
                return False
        return once and not node.name

    def name(self, thing: Any, wish: str = "") -> str:
        """Return the name of a number, an array or a function, and note that it is used."""
        if self.names.around:
            self.names.around.used.add(thing)
        return self.names.of(thing, wish)

    def lines(self, block: Block | None = None, indent: str = "    ") -> Iterator[str]:
        """Yield the lines of a block, by default of the whole function."""
        comment = ""
        for item in (block or self.trace.root).items:
            if isinstance(item, Comment):
                comment = item.text
            elif self._stands(item):
                if comment and comment not in self.commented:
                    self.commented.add(comment)
                    yield from (indent + line for line in self.syntax.comment(comment))
                comment = ""
                yield from (indent + line for line in self.syntax.statement(self, item))

    def _stands(self, item: Any) -> bool:
        """True if an item is a live statement of its own that has not been printed yet."""
        if id(item) not in self.alive or (isinstance(item, Node) and item in self.done):
            return False
        return not (isinstance(item, Node) and self.inlined(item))

    def first(self, values: Iterable[Any], indent: str = "    ") -> Iterator[str]:
        """Yield the lines of all nodes that ``values`` depend on; they precede all other lines."""
        needed: set[Node] = set()
        pending = [*values]
        while pending:
            x = pending.pop()
            if isinstance(x, Node) and x not in needed:
                needed.add(x)
                pending += x.args
        for node in sorted(needed, key=hash):
            if node.op not in LEAVES and node not in self.done and not self.inlined(node):
                self.done.add(node)
                yield from (indent + line for line in self.syntax.statement(self, node))

    def text(self, value: Any, outer: int = CHOICE, kind: str = "") -> str:
        """Return the text of a value, in brackets if its precedence is lower than ``outer``.

        The text is converted to the type ``kind``, that of the expression around it; "": any type.
        """
        if not isinstance(value, Node):
            text = self.syntax.literal(value, kind == REAL)
            return f"({text})" if text.startswith("-") and outer >= PRODUCT else text
        if value.op in LEAVES or value in self.names.given:
            outside = value.op in ("input", "state")
            text = self.syntax.leaf(value, value.name if outside else self.name(value))
            binding = ATOM
        else:
            text, binding = self.expression(value), BINDING.get(value.op, ATOM)
        if kind in (REAL, WHOLE) and value.type not in (REAL, kind):
            converted = self.syntax.operation(f"as {kind}", [text], value)
            binding = binding if converted == text else ATOM
            text = converted
        return f"({text})" if binding < outer else text

    def expression(self, node: Node) -> str:
        """Return the operation of a node, without brackets around it."""
        if node.op == "read":
            storage, place = node.args
            return self.syntax.element(storage, self.name(storage), self.text(place))
        if node.op == "now":
            return self.text(node.args[0])
        kind = REAL if any(map(_real, node.args)) else node.type
        parts = []
        for k, x in enumerate(node.args):
            condition = node.op in ("and", "or", "not", "whole") or (node.op == "?" and not k)
            parts.append(self.text(x, _least(node.op, k), "" if condition else kind))
        return self.syntax.operation(node.op, parts, node)


def _least(op: str, k: int) -> int:
    """Return the precedence that operand ``k`` of an operation needs to stand without brackets."""
    binding = BINDING.get(op, CHOICE)
    if op in ("and", "or"):
        return ORDER  # an inner ``and`` or ``or`` always gets brackets
    if op in ("==", "!=", "<", "<=", ">", ">="):
        return SUM
    return binding if op in ("+", "-", "*", "/") and not k else binding + 1


def _real(x: Any) -> bool:
    return x.type == REAL if isinstance(x, Node) else isinstance(x, float)


def folded(lines: Iterable[str]) -> list[str]:
    """Return lines of at most ``WIDTH`` characters, folded at spaces."""
    result: list[str] = []
    for line in lines:
        more = " " * (len(line) - len(line.lstrip()) + 4)
        result += wrap(
            line,
            WIDTH,
            subsequent_indent=more,
            break_long_words=False,
            break_on_hyphens=False,
            replace_whitespace=False,
        ) or [""]
    return result
