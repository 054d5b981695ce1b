"""C99 of what was recorded."""

import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby
from textwrap import wrap
from typing import Any, NamedTuple

from hfc_design.codegen.axis import Field, Recorded
from hfc_design.codegen.emit import ORDER, PRODUCT, WIDTH, Names, Printer, folded
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
    kind_of,
)

#: Functions that stand before the law where it needs them.
HELPERS = {
    "smaller": "static real smaller(real a, real b)\n{\n    return b < a ? b : a;\n}\n",
    "larger": "static real larger(real a, real b)\n{\n    return b > a ? b : a;\n}\n",
    "magnitude": "static real magnitude(real x)\n{\n    return x < 0 ? -x : x;\n}\n",
    "whole_part": (
        "/* The whole part of a number above 0; of others 0. */\n"
        "static int whole_part(real x)\n{\n    return x > 0 ? (int)x : 0;\n}\n"
    ),
}
HELPERS |= {
    f"{name}_whole": text.replace("real", "int").replace(name, f"{name}_whole")
    for name, text in HELPERS.items()
    if name in ("smaller", "larger", "magnitude")
}
CALLED = {"min": "smaller", "max": "larger", "abs": "magnitude", "whole": "whole_part"}
LIBRARY = {"exp": "EXP", "tanh": "TANH", "sqrt": "SQRT", "sin": "SIN", "cos": "COS"}
WORDS = {"and": "&&", "or": "||", "==": "==", "!=": "!="}
#: What the code itself calls so.
OWN = (
    *("real", "R", "LARGEST", "state", "inputs", "largest", "odd", "overflow", "stepped"),
    *("is_whole", "numbers", "count", "before", *HELPERS, *LIBRARY.values()),
)


class C:
    """See ``emit.Syntax``."""

    fold = False

    def __init__(self, reserved: Iterable[str] = ()) -> None:
        self.helpers: dict[str, None] = {}
        self.library: dict[str, None] = {}
        self.names = Names((*OWN, *reserved))

    def leaf(self, node: Node, name: str) -> str:
        """Inputs and what is remembered are behind pointers."""
        place = {"input": "inputs->", "state": "state->"}.get(node.op, "")
        return place + name

    def literal(self, value: float | bool, real: bool) -> str:
        """A real number is cast, as in float it has to be one of these."""
        if isinstance(value, bool):
            return str(int(value))
        if isinstance(value, int):
            return str(value)
        return f"R({value!r})"

    def operation(self, op: str, parts: list[str], node: Node) -> str:
        """Functions of the library by the names that are for float, too."""
        if op == "real":
            return f"R({parts[0]})"
        if op == "?":
            return f"{parts[0]} ? {parts[1]} : {parts[2]}"
        if op in ("neg", "not"):
            return f"{'-' if op == 'neg' else '!'}{parts[0]}"
        if op in CALLED:
            name = CALLED[op] + ("_whole" if node.type != REAL and op != "whole" else "")
            self.helpers[name] = None
            return f"{name}({', '.join(map(_bare, parts))})"
        if op in LIBRARY:
            self.library[op] = None
            return f"{LIBRARY[op]}({_bare(parts[0])})"
        return f"{parts[0]} {WORDS.get(op, op)} {parts[1]}"

    def element(self, storage: Storage, name: str, place: str) -> str:
        """Arrays are flat."""
        return f"{self._array(storage, name)}[{place}]"

    def _array(self, storage: Storage, name: str) -> str:
        return f"state->{storage.name}" if storage.kind == "state" else name

    def comment(self, text: str) -> list[str]:
        """Nothing in it ends it, or begins another."""
        plain = re.sub(r"[^ -~]|\\\\", "_", text).replace("*/", "* /").replace("/*", "/ *")
        first, *rest = wrap(f"/* {plain} */", WIDTH - 4)
        return [first, *(f" * {line}" for line in rest)]

    def statement(self, printer: Printer, item: Any) -> Iterator[str]:
        """Lines of one."""
        text = printer.text
        if isinstance(item, Node):
            value = printer.expression(item)
            yield f"const {_type(item)} {printer.name(item)} = {value};"
        elif isinstance(item, Storage):
            yield f"real {printer.name(item)}[{item.size}];"
        elif isinstance(item, Store):
            place = f"state->{item.storage.name}"
            if isinstance(item.storage, Storage):
                place = self.element(item.storage, printer.name(item.storage), text(item.place))
            yield f"{place} = {text(item.value, real=True)};"
        elif isinstance(item, Assign):
            first = f"{_type(item.variable)} " if item.first else ""
            real = item.variable.type == REAL
            yield f"{first}{printer.name(item.variable)} = {text(item.value, real=real)};"
        elif isinstance(item, Loop):
            k = printer.name(item.counter, "ijkn"[min(item.block.depth - 1, 3)])
            low, high = text(item.low), text(item.high, ORDER + 1)
            yield f"for (int {k} = {low}; {k} < {high}; {k}++) {{"
            yield from printer.lines(item.block)
            yield "}"
        elif isinstance(item, Branch):
            yield f"if ({text(item.condition)}) {{"
            yield from printer.lines(item.block)
            yield "}"
        elif isinstance(item, Call):
            yield from self._call(printer, item)

    def _call(self, printer: Printer, item: Call) -> Iterator[str]:
        args = []
        for x, parameter in zip(item.args, item.function.parameters, strict=True):
            if isinstance(x, tuple):
                storage, place = x
                array = self._array(storage, printer.name(storage))
                begins = isinstance(place, int) and not place
                args.append(array if begins else f"{array} + {printer.text(place)}")
            else:
                args.append(printer.text(x, real=kind_of(parameter) == REAL))
        numbers = [x for x in item.results if isinstance(x, Node)]
        filled = sum(isinstance(x, Storage) for x in item.function.results)
        args += [printer.name(x) for x in item.results if isinstance(x, Storage)][:filled]
        name = self.names.of(item.function)
        if len(numbers) == 1:
            (one,) = numbers
            yield f"const {_type(one)} {printer.name(one)} = {name}({', '.join(args)});"
            return
        for one in numbers:
            yield f"{_type(one)} {printer.name(one)};"
        args += [f"&{printer.name(one)}" for one in numbers]
        yield f"{name}({', '.join(args)});"

    def function(self, found: Function) -> str:
        """The definition of one."""
        numbers = [x for x in found.results if not isinstance(x, Storage)]
        printer = Printer(found.trace, self, numbers, self.names)
        printer.told.add(found.what)
        parameters = []
        for x in found.parameters:
            if isinstance(x, Node):
                parameters.append(f"{_type(x)} {printer.name(x)}")
            else:
                fixed = "" if x.version else "const "
                parameters.append(f"{fixed}real {printer.name(x)}[{x.size}]")
        for x in found.results:
            if isinstance(x, Storage):
                parameters.append(f"real {printer.name(x)}[{x.size}]")
        several = (
            [printer.names.fresh(f"{getattr(x, 'name', '') or 'part'}_out") for x in numbers]
            if len(numbers) > 1
            else []
        )
        parameters += [
            f"{'real' if kind_of(x) == REAL else 'int'} *{name}"
            for x, name in zip(numbers, several, strict=False)
        ]
        lines = [*printer.lines()]
        lines += [
            f"    *{name} = {printer.text(x, real=kind_of(x) == REAL)};"
            for x, name in zip(numbers, several, strict=False)
        ]
        kind = "void"
        if len(numbers) == 1:
            kind = "real" if kind_of(numbers[0]) == REAL else "int"
            lines.append(f"    return {printer.text(numbers[0], real=kind == 'real')};")
        head = f"static {kind} {self.names.of(found)}({', '.join(parameters)})"
        told = self.comment(found.what) if found.what else []
        return "\n".join(folded([*told, head, "{", *lines, "}", ""]))

    def table(self, storage: Storage) -> str:
        """A table of constants."""
        return _constants(self.names.of(storage), storage.type, storage.shape, storage.numbers)


def _constants(name: str, kind: str, shape: tuple[int, ...], numbers: Sequence[float]) -> str:
    """A row in a line."""
    declared, cast = ("real", "R({!r})") if kind == REAL else ("int", "{:d}")
    if kind != REAL and max(map(abs, numbers)) < 128:
        declared = "signed char"
    count, written = shape[-1], [cast.format(x) for x in numbers]
    rows = [", ".join(written[k : k + count]) for k in range(0, len(written), count)]
    first = f"static const {declared} {name}[{len(written)}] = {{"
    return "\n".join(folded([first, *(f"    {row}," for row in rows), "};"]))


class Program(NamedTuple):
    """The parts of the code of a law, each as lines that end."""

    helpers: list[str]
    numbers: list[str]  # of the design
    functions: list[str]
    state: list[str]  # members
    init: list[str]
    law: list[str]  # what is done in a sample
    command: str
    library: list[str]  # functions of math.h
    stateless: bool


def program(found: Recorded, reserved: Iterable[str] = ()) -> Program:
    """A law in C99; nothing in it has a name that is ``reserved``."""
    c = C(reserved)
    functions = [*found.trace.functions.values()]
    roots = [found.command, *found.doubtful]
    printer = Printer(found.trace, c, roots, c.names, found.after)
    printer.names.found[found.limit] = "largest"
    if isinstance(found.command, Node) and found.command.op not in LEAVES:
        printer.bound.add(found.command)
    things: list[Any] = [*functions, *found.trace.tables.values(), *found.numbers]
    for thing in things:
        c.names.of(thing, thing.name)
    first = [*printer.first(found.doubtful)] if found.early else []
    body, check = [*printer.lines()], _check(printer, found.doubtful)
    after, command = [*printer.lines(found.after)], printer.text(found.command)
    law = [*first, *check, *body, *after] if found.early else [*body, *check, *after]
    if found.started:
        law.append("    state->started = 1;")
    texts = [c.function(one) for one in functions]
    tables = [c.table(x) for x in found.trace.tables.values() if x in c.names.used]
    numbers = [
        f"static const real {c.names.of(x)} = R({x.value!r});"
        for x in found.numbers
        if x in c.names.used
    ]
    state, starts = [], {}
    for k, field in enumerate(found.fields):
        if found.started and found.started[1] == k:
            state.append("int started; /* whether there was a sample before */")
        state.append(f"{{real}} {field.name}{f'[{field.size}]' if field.shape else ''};")
        if field.shape and any(field.start):
            starts[field.name] = c.names.fresh(f"start_{field.name}")
            tables.append(_constants(starts[field.name], REAL, field.shape, field.start))
    init = ["state->started = 0;"] if found.started else []
    for (count, *_), fields in groupby(found.fields, lambda field: (field.size, *field.shape[:1])):
        init += _begin([*fields], count, starts)
    stateless = not any("state" in line for line in law)
    helpers = [HELPERS[name] for name in c.helpers]
    lines = folded(law)
    return Program(
        helpers, [*tables, *numbers], texts, state, init, lines, command, [*c.library], stateless
    )


def _check(printer: Printer, doubtful: list[Any]) -> list[str]:
    if not doubtful:
        return []
    products = " + ".join(f"R(0) * {printer.text(x, PRODUCT + 1)}" for x in doubtful)
    lines = [f"const real overflow = {products};", "if (!(overflow <= 0)) {"]
    return [f"    {line}" for line in (*lines, "    return overflow;", "}")]


def _begin(fields: list[Field], count: int, starts: dict[str, str]) -> list[str]:
    """Set fields of one size."""
    if not fields[0].shape:
        return [f"state->{field.name} = {_plain(field.start[0])};" for field in fields]
    first = {
        field.name: f"{starts[field.name]}[k]" if field.name in starts else "0" for field in fields
    }
    lines = (f"    state->{name}[k] = {value};" for name, value in first.items())
    return [f"for (int k = 0; k < {count}; k++) {{", *lines, "}"]


def _plain(x: float) -> str:
    return f"R({x!r})" if x else "0"


def _type(node: Node) -> str:
    return "real" if node.type == REAL else "int"


def _bare(text: str) -> str:
    """Without brackets around all of it."""
    if not (text.startswith("(") and text.endswith(")")):
        return text
    depth = 0
    for k, x in enumerate(text):
        depth += (x == "(") - (x == ")")
        if not depth:
            return text[1:-1] if k == len(text) - 1 else text
    return text
