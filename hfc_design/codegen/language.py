"""Base class of output languages: their common parts, and the printing of a whole law."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, ClassVar, NamedTuple

from hfc_design.codegen.emit import ORDER, Names, Printer, folded
from hfc_design.codegen.live import LEAVES
from hfc_design.codegen.nodes import (
    REAL,
    WHOLE,
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
    """Language in which laws are printed; it has functions, or needs ``flat`` recordings."""

    fold = False  # True if names do not differ by upper and lower case
    chooses: frozenset[str] = frozenset()  # operations printed as statements, not in expressions
    types: Mapping[str, str] = dict.fromkeys(("real", "whole", "truth"), "")  # type -> its name
    places: Mapping[str, str] = {}  # "input" or "state" -> what is printed before its name
    functions: Mapping[str, str] = {}  # operation -> function that computes it
    words: Mapping[str, str] = {}  # operation -> operator, if it differs from the operation
    #: Templates: a named value, a variable, an assignment, the declaration of a local array, a
    #: number of the design, and the first lines of a loop and of a branch.
    forms: ClassVar[Mapping[str, str]]
    end: ClassVar[Mapping[type, str]] = {Loop: "}", Branch: "}"}
    helpers_of: ClassVar[Mapping[str, str]] = {}  # name -> definition of a function to print

    def __init__(self, reserved: Iterable[str]) -> None:
        self.helpers: dict[str, None] = {}
        self.library: dict[str, None] = {}
        self.declared: dict[str, tuple[str, int]] = {}  # name -> (type, size of an array or 0)
        self.names = Names(reserved, self.fold)

    # Methods that every language defines.

    @abstractmethod
    def literal(self, value: float | bool, real: bool) -> str:
        """Return the text of a number; ``real`` is true if it is among real numbers."""

    @abstractmethod
    def comment(self, text: str) -> list[str]:
        """Return the lines of a comment."""

    @abstractmethod
    def checked(self, text: Callable[..., str], doubtful: list[Any]) -> list[str]:
        """Return lines that end the sample if any of ``doubtful`` (see ``text``) is not finite."""

    @abstractmethod
    def constants(
        self, name: str, kind: str, shape: tuple[int, ...], numbers: Sequence[float]
    ) -> str:
        """Return the definition of a table of constants, one row per line."""

    # Methods that only languages with functions define.

    def called(self, printer: Printer, item: Call) -> Iterator[str]:
        """Yield the lines of a call."""
        raise NotImplementedError

    def function(self, recorded: Function) -> str:
        """Return the definition of a function."""
        raise NotImplementedError

    # Methods that most languages share.

    def leaf(self, node: Node, name: str) -> str:
        """Return the text of a number from outside, such as an input, or of a variable."""
        return self.places.get(node.op, "") + name

    def array(self, storage: Storage, name: str) -> str:
        """Return the name of a whole array."""
        return self.places["state"] + storage.name if storage.kind == "state" else name

    def element(self, storage: Storage, name: str, place: str) -> str:
        """Return the text of a number of an array; arrays have one dimension."""
        return f"{self.array(storage, name)}[{place}]"

    def operation(self, op: str, parts: list[str], node: Node) -> str:
        """Return the text of an operation on ``parts``, the texts of its operands."""
        if op in self.functions:
            name = self.functions[op]
            if name in self.helpers_of:
                self.helpers[name] = None
            return f"{name}({', '.join(parts)})"
        if len(parts) == 1:
            return self.words[op] + parts[0]
        if op == "?":
            return f"{parts[0]} ? {parts[1]} : {parts[2]}"
        return f"{parts[0]} {self.words.get(op, op)} {parts[1]}"

    def value(self, printer: Printer, node: Node) -> Iterator[str]:
        """Yield the lines that compute a number and give it a name."""
        yield self.form("named", node.type, printer.name(node), value=printer.expression(node))

    def counter(self, printer: Printer, item: Loop) -> str:
        """Return the name of a loop's counter."""
        return printer.name(item.counter, "ijkn"[min(item.block.depth - 1, 3)])

    def constant(self, name: str, value: float) -> str:
        """Return the definition of a number of the design."""
        return self.forms["constant"].format(name=name, value=value)

    def form(self, form: str, kind: str, name: str, size: int = 0, **parts: Any) -> str:
        """Return a statement from ``forms`` that introduces a name, which is noted as declared."""
        self.declared[name] = kind, size
        return self.forms[form].format(type=self.types[kind], name=name, size=size, **parts)

    def folded(self, lines: Iterable[str]) -> list[str]:
        """Return the lines, folded to a limited width."""
        return folded(lines)

    def rows(self, kind: str, shape: tuple[int, ...], numbers: Sequence[float]) -> list[str]:
        """Return the lines of a table; the last one ends with a comma, too."""
        written = [self.literal(x if kind == REAL else int(x), kind == REAL) for x in numbers]
        lines = (written[k : k + shape[-1]] for k in range(0, len(written), shape[-1]))
        return [f"    {', '.join(row)}," for row in lines]

    def assigned(self, place: str, value: str) -> str:
        """Return an assignment to a variable."""
        return self.forms["assigned"].format(name=place, value=value)

    def statement(self, printer: Printer, item: Any) -> Iterator[str]:
        """Yield the lines of an item of a block: a node, a declaration or a statement."""
        text, name = printer.text, printer.name
        if isinstance(item, Node):
            yield from self.value(printer, item)
        elif isinstance(item, Storage):
            yield from filter(None, [self.form("declared", item.type, name(item), item.size)])
        elif isinstance(item, Store):
            if isinstance(item.storage, Node):
                place = self.leaf(item.storage, item.storage.name)
            else:
                place = self.element(item.storage, name(item.storage), text(item.place))
            yield self.assigned(place, text(item.value, kind=REAL))
        elif isinstance(item, Assign):
            kind, variable = item.variable.type, name(item.variable)
            value = text(item.value, kind=kind)
            if item.first:
                yield self.form("variable", kind, variable, value=value)
            else:
                yield self.assigned(variable, value)
        elif isinstance(item, Loop):
            k, low, high = self.counter(printer, item), text(item.low), text(item.high, ORDER + 1)
            last = str(int(high) - 1) if high.isdigit() else f"{high} - 1"
            yield self.form("loop", WHOLE, k, low=low, high=high, last=last)
            yield from printer.lines(item.block)
            yield self.end[Loop]
        elif isinstance(item, Branch):
            yield self.forms["branch"].format(condition=text(item.condition))
            yield from printer.lines(item.block)
            yield self.end[Branch]
        elif isinstance(item, Call):
            yield from self.called(printer, item)


class Printed(NamedTuple):
    """Parts of the code of a law, each as lines."""

    helpers: list[str]
    constants: list[str]
    functions: list[str]
    law: list[str]  # statements of a sample
    commands: list[str]  # expression of the command of each axis
    starts: dict[str, str]  # name of an array in memory -> name of the table of its start values
    library: list[str]  # mathematical functions of the language that the code calls
    stateless: bool  # True if a sample does not use the memory
    state: list[str] = []  # declarations of the memory, if the language has them
    init: list[str] = []  # lines that set the memory to its start values


def printed(recording: Recorded, syntax: Language) -> Printed:
    """Return the code of a recorded law in the language ``syntax``."""
    functions = [*recording.trace.functions.values()]
    roots = [*recording.commands, *recording.doubtful]
    printer = Printer(recording.trace, syntax, roots, syntax.names, recording.after)
    if isinstance(recording.limit, Node) and recording.limit.op == "parameter":
        printer.names.given[recording.limit] = "largest"
    printer.bound |= {x for x in recording.commands if isinstance(x, Node) and x.op not in LEAVES}
    things: list[Any] = [*functions, *recording.trace.tables.values(), *recording.numbers]
    for thing in things:
        syntax.names.of(thing, thing.name)
    first = [*printer.first(recording.doubtful)] if recording.early else []
    body = [*printer.lines()]
    check = syntax.checked(printer.text, recording.doubtful) if recording.doubtful else []
    check = [f"    {line}" for line in check]
    after = [*printer.lines(recording.after)]
    commands = [printer.text(command, kind=REAL) for command in recording.commands]
    law = [*first, *check, *body, *after] if recording.early else [*body, *check, *after]
    if recording.started:
        flag = syntax.leaf(recording.started[0], recording.started[0].name)
        law.append(f"    {syntax.assigned(flag, syntax.literal(True, False))}")
    texts = [syntax.function(one) for one in functions]
    constants, starts = _constants(recording, syntax)
    return Printed(
        helpers=[syntax.helpers_of[name] for name in syntax.helpers],
        constants=constants,
        functions=texts,
        law=syntax.folded(law),
        commands=commands,
        starts=starts,
        library=[*syntax.library],
        stateless=not any("state" in line for line in law),
    )


def _constants(recording: Recorded, syntax: Language) -> tuple[list[str], dict[str, str]]:
    """Return the definitions of all constants, and ``Printed.starts``."""
    names, starts = syntax.names.of, {}
    used = [x for x in recording.trace.tables.values() if x in syntax.names.used]
    lines = [syntax.constants(names(x), x.type, x.shape, x.numbers) for x in used]
    for field in recording.fields:
        if field.shape and any(field.start):
            starts[field.name] = syntax.names.fresh(f"start_{field.name}")
            lines.append(syntax.constants(starts[field.name], REAL, field.shape, field.start))
    for x in recording.numbers:
        if x in syntax.names.used and x.value is not None:
            lines.append(syntax.constant(names(x), float(x.value)))
    return lines, starts


def larger(condition: Any, a: Any, b: Any) -> bool:
    """True if a choice of ``a`` or ``b`` by ``condition`` gives the larger one: it is a > b."""
    if not isinstance(condition, Node) or condition.op != ">":
        return False

    def same(x: Any, y: Any) -> bool:
        return x is y or (not isinstance(x, Node) and not isinstance(y, Node) and x == y)

    return all(map(same, (a, b), condition.args))
