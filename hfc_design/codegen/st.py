"""Printer of recorded laws in Structured Text (IEC 61131-3), with what every compiler gets right.

A law is one function block with LREAL, DINT and BOOL, arrays of one dimension, and functions of the
standard. The standard has no TANH, which is computed by EXP.
"""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import groupby
from textwrap import wrap
from typing import Any, NamedTuple

from hfc_design.codegen.emit import WIDTH, Printer, folded
from hfc_design.codegen.language import Language, larger, printed
from hfc_design.codegen.nodes import REAL, TRUTH, WHOLE, Branch, Loop, Node, Storage, TraceError
from hfc_design.codegen.recorded import Recorded

TYPES = {REAL: "LREAL", WHOLE: "DINT", TRUTH: "BOOL"}
FUNCTIONS = {name: name.upper() for name in ("min", "max", "abs", "exp", "sqrt", "sin", "cos")}
#: Operations that take several statements; beyond 20 TANH is 1 to the last digit.
STEPS = {
    "tanh": (
        "{name} := EXP(2.0 * MAX(MIN({x}, 20.0), -20.0));",
        "{name} := ({name} - 1.0) / ({name} + 1.0);",
    ),
    "floor": (
        "{name} := LINT_TO_LREAL(LREAL_TO_LINT({x})); (* to the nearest, then down *)",
        "IF {name} > {x} THEN {name} := {name} - 1.0; END_IF;",
    ),
    "whole": (
        "{name} := LREAL_TO_DINT(MAX({x}, 0.0)); (* to the nearest, then down *)",
        "IF DINT_TO_LREAL({name}) > MAX({x}, 0.0) THEN {name} := {name} - 1; END_IF;",
    ),
}
#: Names that the block itself uses.
COUNTERS = ("i", "j", "k", "n", "n_5", "n_6", "n_7", "n_8")
OWN = ("reset", "fault", "greatest", *COUNTERS)
#: Largest finite number as a product: matiec takes no literal beyond single precision.
GREATEST = f"17976.0{' * 1.0E38' * 8}"


class Variable(NamedTuple):
    """Variable of a function block."""

    name: str
    type: str
    size: int = 0  # number of values of an array; 0: a single value
    first: Sequence[float] = ()  # start values
    columns: int = 7  # number of columns of a table


class Block(NamedTuple):
    """Law as a function block."""

    constants: list[Variable]
    remembered: list[Variable]
    within: list[Variable]
    lines: list[str]  # statements of a sample

    @property
    def sections(self) -> dict[str, list[Variable]]:
        """Variables of the block, by their purpose."""
        return {
            "constant": self.constants,
            "remembered from one sample to the next": self.remembered,
            "within a sample": self.within,
        }

    def listed(self, variables: list[Variable]) -> list[str]:
        """Return declarations of variables without size and first value, one line for each type."""
        plain = sorted((x for x in variables if not (x.size or x.first)), key=lambda x: x.type)
        kinds = groupby(plain, lambda x: x.type)
        return folded(
            f"{', '.join(x.name for x in variables)} : {kind};" for kind, variables in kinds
        )

    @property
    def body(self) -> str:
        """Statements of a sample."""
        return "".join(f"{line}\n" for line in self.lines)


def literal_of(value: float, kind: str = TYPES[REAL]) -> str:
    """Return a literal that is read back bit for bit; a real number always has a point."""
    if kind != TYPES[REAL]:
        return str(bool(value)).upper() if kind == TYPES[TRUTH] else str(int(value))
    mantissa, _, exponent = repr(float(value)).partition("e")
    mantissa = mantissa if "." in mantissa else f"{mantissa}.0"
    return f"{mantissa}E{int(exponent)}" if exponent else mantissa


class StructuredText(Language):
    """Structured Text, see ``Language``."""

    fold = True
    chooses = frozenset(("?", *STEPS))
    types = TYPES
    functions = FUNCTIONS
    words = {"neg": "-", "not": "NOT ", "and": "AND", "or": "OR", "==": "=", "!=": "<>"}
    forms = dict.fromkeys(("named", "variable", "assigned"), "{name} := {value};") | {
        "declared": "",
        "loop": "FOR {name} := {low} TO {last} DO",
        "branch": "IF {condition} THEN",
    }
    end = {Loop: "END_FOR;", Branch: "END_IF;"}

    def __init__(self, reserved: Iterable[str] = ()) -> None:
        super().__init__((*OWN, *reserved))
        self.fields: dict[object, str] = {}  # node or storage of the memory -> its name
        self.tables: list[Variable] = []

    def leaf(self, node: Node, name: str) -> str:
        return self.fields.get(node, name)

    def literal(self, value: float | bool, real: bool) -> str:
        kind = TRUTH if isinstance(value, bool) else WHOLE
        return literal_of(value, TYPES[REAL if real or isinstance(value, float) else kind])

    def operation(self, op: str, parts: list[str], node: Node) -> str:
        if op.startswith("as "):
            return f"{TYPES[node.type]}_TO_{TYPES[op.removeprefix('as ')]}({parts[0]})"
        if op == "rint":
            return f"LINT_TO_LREAL(LREAL_TO_LINT({parts[0]}))"
        if op.isalnum() and op not in self.functions and op not in self.words:
            raise TraceError(f"calls {op}, which Structured Text does not have")
        return super().operation(op, parts, node)

    def value(self, printer: Printer, node: Node) -> Iterator[str]:
        if node.op not in self.chooses:
            yield from super().value(printer, node)
            return
        name, text = printer.name(node), printer.text
        self.declared[name] = node.type, 0
        if node.op in STEPS:
            x = text(node.args[0], kind=REAL)
            yield from (line.format(name=name, x=x) for line in STEPS[node.op])
            return
        condition, *values = node.args
        a, b = (text(x, kind=node.type) for x in values)
        if larger(condition, *values):
            yield f"{name} := MAX({a}, {b});"
            return
        lines = [f"IF {text(condition)} THEN", f"    {name} := {a};", "ELSE", f"    {name} := {b};"]
        short = " ".join(map(str.strip, (*lines, "END_IF;")))
        yield from [short] if len(short) < WIDTH - 12 else (*lines, "END_IF;")

    def array(self, storage: Storage, name: str) -> str:
        return self.fields.get(storage, name)

    def comment(self, text: str) -> list[str]:
        plain = re.sub(r"[^ -~]|\\$", "_", text).replace("*)", "* )").replace("(*", "( *")
        first, *rest = wrap(f"(* {plain} *)", WIDTH - 4)
        return [first, *(f"   {line}" for line in rest)]

    def counter(self, printer: Printer, item: Loop) -> str:
        printer.names.given[item.counter] = name = COUNTERS[item.block.depth - 1]
        return name

    def checked(self, text: Callable[..., str], doubtful: list[Any]) -> list[str]:
        return _left(map(text, doubtful))

    def constants(
        self, name: str, kind: str, shape: tuple[int, ...], numbers: Sequence[float]
    ) -> str:
        self.tables.append(Variable(name, TYPES[kind], len(numbers), numbers, shape[-1]))
        return ""

    def constant(self, name: str, value: float) -> str:
        self.tables.append(Variable(name, TYPES[REAL], 0, (value,)))
        return ""


def _left(values: Iterable[str]) -> list[str]:
    """Return lines that leave the block if any of ``values`` is infinite or not a number."""
    finite = " AND ".join(f"(ABS({x}) <= greatest)" for x in values)
    outer = f"({finite})" if " AND " in finite else finite
    return [f"IF NOT {outer} THEN", "    RETURN;", "END_IF;"]


def program(recording: Recorded, outputs: list[str], reserved: Iterable[str] = ()) -> Block:
    """Return the function block of a controller; ``outputs`` are the names of its commands.

    No variable besides inputs and outputs has a name that is ``reserved``.
    """
    inputs = [x.name for x in recording.inputs]
    syntax = StructuredText((*reserved, *inputs, *outputs))
    remembered = []
    for k, field in enumerate(recording.fields):
        wish = f"previous_{field.name}" if field.name in inputs else field.name
        name = syntax.fields[field.holds] = syntax.names.fresh(wish)
        size = field.size if field.shape else 0
        remembered.append(Variable(name, "LREAL", size, field.start, (field.shape or (1,))[-1]))
        if recording.started and recording.started[1] == k:
            flag = syntax.fields[recording.started[0]] = syntax.names.fresh("started")
            remembered.append(Variable(flag, "BOOL"))
    parts = printed(recording, syntax)
    tables = {
        syntax.fields[field.holds]: parts.starts.get(field.name) for field in recording.fields
    }
    begin = [*_begin(remembered, tables)]
    syntax.declared["greatest"] = REAL, 0
    if any(x.size for x in remembered):
        syntax.declared["k"] = WHOLE, 0
    lines = [
        *(["IF reset THEN", *begin, "END_IF;", ""] if begin else []),
        *("(* The largest finite number. *)", f"greatest := {GREATEST};"),
        *("fault := TRUE;", *(f"{output} := 0.0;" for output in outputs)),
        *_left(x.name for x in recording.inputs if x.type == REAL),
        *(line.removeprefix("    ") for line in parts.law),
        *(f"{one} := {value};" for one, value in zip(outputs, parts.commands, strict=True)),
        # A connected controller is also at fault after it has stopped itself.
        f"fault := {'tripped > 0.5' if any(x.name == 'tripped' for x in remembered) else 'FALSE'};",
    ]
    within = [Variable(name, TYPES[kind], size) for name, (kind, size) in syntax.declared.items()]
    return Block(syntax.tables, remembered, within, folded(lines))


def _begin(remembered: list[Variable], tables: Mapping[str, str | None]) -> Iterator[str]:
    """Yield lines that set the memory to its start; ``tables``: array -> table, None: zeros."""
    for x in remembered:
        if x.size:
            table = tables[x.name]
            yield f"    FOR k := 0 TO {x.size - 1} DO"
            yield f"        {x.name}[k] := {f'{table}[k]' if table else '0.0'};"
            yield "    END_FOR;"
        else:
            yield f"    {x.name} := {literal_of(x.first[0] if x.first else 0.0, x.type)};"
