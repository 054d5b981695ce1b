"""How a language writes what was recorded: what is the same in all of them, and the whole law."""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

from hfc_design.codegen.emit import ORDER, Names, Printer
from hfc_design.codegen.live import LEAVES
from hfc_design.codegen.nodes import (
    REAL,
    Assign,
    Branch,
    Call,
    Function,
    Loop,
    Node,
    Storage,
    Store,
)
from hfc_design.codegen.recorded import Recorded


class Language(ABC):
    """One that a law is printed in: those of C's family, and those that are told in ``flat``."""

    fold = False  # whether upper and lower case are alike
    chooses: frozenset[str] = frozenset()  # operations that are statements of their own
    end = {Loop: "}", Branch: "}"}

    def __init__(self, own: Iterable[str]) -> None:
        self.helpers: dict[str, None] = {}
        self.library: dict[str, None] = {}
        self.names = Names(own, self.fold)

    # What each has to say.

    @abstractmethod
    def leaf(self, node: Node, name: str) -> str:
        """A number that is known outside, or a variable."""

    @abstractmethod
    def literal(self, value: float | bool, real: bool) -> str:
        """A number of the law; ``real``: among real ones."""

    @abstractmethod
    def operation(self, op: str, parts: list[str], node: Node) -> str:
        """An operation of its parts, in brackets where they need some."""

    @abstractmethod
    def array(self, storage: Storage, name: str) -> str:
        """The name of an array as a whole."""

    @abstractmethod
    def comment(self, text: str) -> list[str]:
        """Lines of a comment."""

    @abstractmethod
    def named(self, kind: str, name: str, value: str) -> str:
        """A value that stays, of a type of ``nodes``."""

    @abstractmethod
    def loop(self, k: str, low: str, high: str) -> str:
        """The head of a loop."""

    def counter(self, printer: Printer, item: Loop) -> str:
        """The name of that of a loop."""
        return printer.name(item.counter, "ijkn"[min(item.block.depth - 1, 3)])

    @abstractmethod
    def branch(self, condition: str) -> str:
        """The head of a branch."""

    @abstractmethod
    def declared(self, name: str, storage: Storage) -> list[str]:
        """An array within a sample."""

    @abstractmethod
    def checked(self, printer: Printer, doubtful: list[Any]) -> list[str]:
        """Leave where one of these is not finite."""

    @abstractmethod
    def constants(
        self, name: str, kind: str, shape: tuple[int, ...], numbers: Sequence[float]
    ) -> str:
        """A table of constants, a row in a line."""

    @abstractmethod
    def constant(self, name: str, value: float) -> str:
        """A number of the design."""

    @abstractmethod
    def folded(self, lines: Iterable[str]) -> list[str]:
        """Lines of no more than a width."""

    # What only some are asked for: those with functions, or where a choice is a statement.

    def called(self, printer: Printer, item: Call) -> Iterator[str]:
        """Lines of a call."""
        raise NotImplementedError

    def chosen(self, printer: Printer, node: Node) -> Iterator[str]:
        """Lines of an operation that is a statement of its own."""
        raise NotImplementedError

    def function(self, found: Function) -> str:
        """The definition of one."""
        raise NotImplementedError

    def helper(self, name: str) -> str:
        """A function of the language's own."""
        raise NotImplementedError

    # What most write alike.

    def variable(self, kind: str, name: str, value: str) -> str:
        """A value that changes."""
        return self.named(kind, name, value)

    def assigned(self, place: str, value: str) -> str:
        """Another value for a variable."""
        return f"{place} = {value};"

    def element(self, storage: Storage, name: str, place: str) -> str:
        """A number of an array; arrays are flat."""
        return f"{self.array(storage, name)}[{place}]"

    def rows(self, kind: str, shape: tuple[int, ...], numbers: Sequence[float]) -> list[str]:
        """Lines of a table, of which the last one ends with a comma, too."""
        written = [self.literal(x if kind == REAL else int(x), kind == REAL) for x in numbers]
        lines = (written[k : k + shape[-1]] for k in range(0, len(written), shape[-1]))
        return [f"    {', '.join(row)}," for row in lines]

    def statement(self, printer: Printer, item: Any) -> Iterator[str]:
        """Lines of a declaration or of a statement."""
        text = printer.text
        if isinstance(item, Node):
            if item.op in self.chooses:
                yield from self.chosen(printer, item)
            else:
                yield self.named(item.type, printer.name(item), printer.expression(item))
        elif isinstance(item, Storage):
            yield from self.declared(printer.name(item), item)
        elif isinstance(item, Store):
            if isinstance(item.storage, Node):
                place = self.leaf(item.storage, item.storage.name)
            else:
                place = self.element(item.storage, printer.name(item.storage), text(item.place))
            yield self.assigned(place, text(item.value, kind=REAL))
        elif isinstance(item, Assign):
            kind, name = item.variable.type, printer.name(item.variable)
            value = text(item.value, kind=kind)
            yield self.variable(kind, name, value) if item.first else self.assigned(name, value)
        elif isinstance(item, Loop):
            yield self.loop(self.counter(printer, item), text(item.low), text(item.high, ORDER + 1))
            yield from printer.lines(item.block)
            yield self.end[Loop]
        elif isinstance(item, Branch):
            yield self.branch(text(item.condition))
            yield from printer.lines(item.block)
            yield self.end[Branch]
        elif isinstance(item, Call):
            yield from self.called(printer, item)


class Printed(NamedTuple):
    """The parts of the code of a law, each as lines."""

    helpers: list[str]
    constants: list[str]
    functions: list[str]
    law: list[str]  # what is done in a sample
    commands: list[str]  # of each axis
    starts: dict[str, str]  # name of an array that is remembered -> of what it starts from
    library: list[str]  # functions of the language's mathematics
    stateless: bool
    state: list[str] = []  # members, where the language declares them
    init: list[str] = []


def printed(found: Recorded, syntax: Language) -> Printed:
    """A law in a language."""
    functions = [*found.trace.functions.values()]
    roots = [*found.commands, *found.doubtful]
    printer = Printer(found.trace, syntax, roots, syntax.names, found.after)
    if isinstance(found.limit, Node) and found.limit.op == "parameter":
        printer.names.found[found.limit] = "largest"
    printer.bound |= {x for x in found.commands if isinstance(x, Node) and x.op not in LEAVES}
    things: list[Any] = [*functions, *found.trace.tables.values(), *found.numbers]
    for thing in things:
        syntax.names.of(thing, thing.name)
    first = [*printer.first(found.doubtful)] if found.early else []
    body, check = [*printer.lines()], _check(printer, found.doubtful)
    after = [*printer.lines(found.after)]
    commands = [printer.text(command, kind=REAL) for command in found.commands]
    law = [*first, *check, *body, *after] if found.early else [*body, *check, *after]
    if found.started:
        flag = syntax.leaf(found.started[0], found.started[0].name)
        law.append(f"    {syntax.assigned(flag, syntax.literal(True, False))}")
    texts = [syntax.function(one) for one in functions]
    constants, starts = _constants(found, syntax)
    helpers = [syntax.helper(name) for name in syntax.helpers]
    stateless = not any("state" in line for line in law)
    return Printed(
        helpers,
        constants,
        texts,
        syntax.folded(law),
        commands,
        starts,
        [*syntax.library],
        stateless,
    )


def _constants(found: Recorded, syntax: Language) -> tuple[list[str], dict[str, str]]:
    """Lines of all constants, and names of what arrays start from."""
    names, starts = syntax.names.of, {}
    used = [x for x in found.trace.tables.values() if x in syntax.names.used]
    lines = [syntax.constants(names(x), x.type, x.shape, x.numbers) for x in used]
    for field in found.fields:
        if field.shape and any(field.start):
            starts[field.name] = syntax.names.fresh(f"start_{field.name}")
            lines.append(syntax.constants(starts[field.name], REAL, field.shape, field.start))
    for x in found.numbers:
        if x in syntax.names.used and x.value is not None:
            lines.append(syntax.constant(names(x), float(x.value)))
    return lines, starts


def _check(printer: Printer, doubtful: list[Any]) -> list[str]:
    if not doubtful:
        return []
    return [f"    {line}" for line in printer.syntax.checked(printer, doubtful)]


def larger(condition: Any, a: Any, b: Any) -> bool:
    """Whether a choice is that of the larger of two numbers."""
    if not isinstance(condition, Node) or condition.op != ">":
        return False
    pairs = zip((a, b), condition.args, strict=True)
    literal = (not isinstance(x, Node) and not isinstance(y, Node) and x == y for x, y in pairs)
    return all(x is y or same for x, y, same in zip((a, b), condition.args, literal, strict=True))
