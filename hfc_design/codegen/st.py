"""Structured Text (IEC 61131-3) of what was recorded: what every compiler gets right.

One function block of LREAL, DINT and BOOL, with arrays of one dimension and no function but those
of the standard: there is no TANH, so that it is made of EXP.
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby
from textwrap import wrap
from typing import Any, NamedTuple

from hfc_design.codegen.emit import WIDTH, Printer, folded
from hfc_design.codegen.language import Language, larger, printed
from hfc_design.codegen.nodes import REAL, TRUTH, WHOLE, Branch, Loop, Node, Storage, TraceError
from hfc_design.codegen.recorded import Recorded

TYPES = {REAL: "LREAL", WHOLE: "DINT", TRUTH: "BOOL"}
FUNCTIONS = {"min": "MIN", "max": "MAX", "abs": "ABS", "exp": "EXP", "sqrt": "SQRT"}
FUNCTIONS |= {"sin": "SIN", "cos": "COS"}
WORDS = {"and": "AND", "or": "OR", "==": "=", "!=": "<>"}
#: Where TANH is 1 to the last digit.
FAR = 20.0
#: What the block itself calls so.
COUNTERS = ("i", "j", "k", "n", "n_5", "n_6", "n_7", "n_8")
OWN = ("reset", "fault", "greatest", *COUNTERS)
#: The largest finite number is a product of it: matiec takes no literal beyond single precision.
GREATEST = f"17976.0{' * 1.0E38' * 8}"


class Variable(NamedTuple):
    """One of a block."""

    name: str
    type: str
    size: int = 0  # of an array; 0: it is none
    first: Sequence[float] = ()  # what it starts from
    columns: int = 7  # of a table


class Block(NamedTuple):
    """A law as a function block."""

    constants: list[Variable]
    remembered: list[Variable]
    within: list[Variable]
    lines: list[str]  # what is done in a sample

    @property
    def sections(self) -> dict[str, list[Variable]]:
        """Its own variables, by what they are for."""
        return {
            "constant": self.constants,
            "remembered from one sample to the next": self.remembered,
            "within a sample": self.within,
        }

    def listed(self, variables: list[Variable]) -> list[str]:
        """Those of no size and no first value, all of a type together."""
        plain = sorted((x for x in variables if not (x.size or x.first)), key=lambda x: x.type)
        kinds = groupby(plain, lambda x: x.type)
        return folded(f"{', '.join(x.name for x in found)} : {kind};" for kind, found in kinds)

    @property
    def body(self) -> str:
        """What is done in a sample."""
        return "".join(f"{line}\n" for line in self.lines)


def literal_of(value: float, kind: str = TYPES[REAL]) -> str:
    """A literal that reads back bit for bit: IEC 61131-3 wants a point in each of a real number."""
    if kind != TYPES[REAL]:
        return str(bool(value)).upper() if kind == TYPES[TRUTH] else str(int(value))
    mantissa, _, exponent = repr(float(value)).partition("e")
    mantissa = mantissa if "." in mantissa else f"{mantissa}.0"
    return f"{mantissa}E{int(exponent)}" if exponent else mantissa


class StructuredText(Language):
    """See ``Language``."""

    fold = True
    chooses = frozenset(("?", "whole", "tanh", "floor"))
    end = {Loop: "END_FOR;", Branch: "END_IF;"}

    def __init__(self, reserved: Iterable[str] = ()) -> None:
        super().__init__((*OWN, *reserved))
        self.fields: dict[object, str] = {}  # names of what is remembered
        self.within: dict[str, Variable] = {}
        self.tables: list[Variable] = []

    def leaf(self, node: Node, name: str) -> str:
        return self.fields.get(node, name)

    def literal(self, value: float | bool, real: bool) -> str:
        kind = TRUTH if isinstance(value, bool) else WHOLE
        return literal_of(value, TYPES[REAL if real or isinstance(value, float) else kind])

    def operation(self, op: str, parts: list[str], node: Node) -> str:
        if op.startswith("as "):
            return f"{TYPES[node.type]}_TO_{TYPES[op.removeprefix('as ')]}({parts[0]})"
        if op in ("neg", "not"):
            return f"-{parts[0]}" if op == "neg" else f"NOT {parts[0]}"
        if op == "rint":
            return f"LINT_TO_LREAL(LREAL_TO_LINT({parts[0]}))"
        if op not in FUNCTIONS and op.isalpha() and op not in WORDS:
            raise TraceError(f"calls {op}, which Structured Text has not")
        if op in FUNCTIONS:
            return f"{FUNCTIONS[op]}({', '.join(parts)})"
        return f"{parts[0]} {WORDS.get(op, op)} {parts[1]}"

    def chosen(self, printer: Printer, node: Node) -> Iterator[str]:
        name, text = self._variable(node.type, printer.name(node)), printer.text
        if node.op == "?":
            condition, *values = node.args
            a, b = (text(x, kind=node.type) for x in values)
            if larger(condition, *values):
                yield f"{name} := MAX({a}, {b});"
                return
            lines = (
                f"IF {text(condition)} THEN",
                f"    {name} := {a};",
                "ELSE",
                f"    {name} := {b};",
            )
            short = " ".join(map(str.strip, (*lines, "END_IF;")))
            yield from [short] if len(short) < WIDTH - 12 else (*lines, "END_IF;")
            return
        x = text(node.args[0], kind=REAL)
        if node.op == "tanh":
            yield f"{name} := EXP(2.0 * MAX(MIN({x}, {FAR}), -{FAR}));"
            yield f"{name} := ({name} - 1.0) / ({name} + 1.0);"
            return
        if node.op == "floor":
            yield f"{name} := LINT_TO_LREAL(LREAL_TO_LINT({x})); (* to the nearest, then down *)"
            yield f"IF {name} > {x} THEN {name} := {name} - 1.0; END_IF;"
            return
        yield f"{name} := LREAL_TO_DINT(MAX({x}, 0.0)); (* to the nearest, then down *)"
        yield f"IF DINT_TO_LREAL({name}) > MAX({x}, 0.0) THEN {name} := {name} - 1; END_IF;"

    def array(self, storage: Storage, name: str) -> str:
        return self.fields.get(storage, name)

    def comment(self, text: str) -> list[str]:
        plain = re.sub(r"[^ -~]|\\$", "_", text).replace("*)", "* )").replace("(*", "( *")
        first, *rest = wrap(f"(* {plain} *)", WIDTH - 4)
        return [first, *(f"   {line}" for line in rest)]

    def _variable(self, kind: str, name: str, size: int = 0) -> str:
        self.within[name] = Variable(name, TYPES[kind], size)
        return name

    def named(self, kind: str, name: str, value: str) -> str:
        return f"{self._variable(kind, name)} := {value};"

    def declared(self, name: str, storage: Storage) -> list[str]:
        self._variable(storage.type, name, storage.size)
        return []

    def assigned(self, place: str, value: str) -> str:
        return f"{place} := {value};"

    def loop(self, k: str, low: str, high: str) -> str:
        self._variable(WHOLE, k)
        last = str(int(high) - 1) if high.isdigit() else f"{high} - 1"
        return f"FOR {k} := {low} TO {last} DO"

    def counter(self, printer: Printer, item: Loop) -> str:
        printer.names.found[item.counter] = name = COUNTERS[item.block.depth - 1]
        return name

    def branch(self, condition: str) -> str:
        return f"IF {condition} THEN"

    def checked(self, printer: Printer, doubtful: list[Any]) -> list[str]:
        return _left(map(printer.text, doubtful))

    def constants(
        self, name: str, kind: str, shape: tuple[int, ...], numbers: Sequence[float]
    ) -> str:
        self.tables.append(Variable(name, TYPES[kind], len(numbers), numbers, shape[-1]))
        return ""

    def constant(self, name: str, value: float) -> str:
        self.tables.append(Variable(name, TYPES[REAL], 0, (value,)))
        return ""

    def folded(self, lines: Iterable[str]) -> list[str]:
        return folded(lines)


def _left(values: Iterable[str]) -> list[str]:
    """Leave where one of these is infinite or no number."""
    finite = " AND ".join(f"(ABS({x}) <= greatest)" for x in values)
    outer = f"({finite})" if " AND " in finite else finite
    return [f"IF NOT {outer} THEN", "    RETURN;", "END_IF;"]


def program(found: Recorded, outputs: list[str], reserved: Iterable[str] = ()) -> Block:
    """A controller as a function block with ``outputs``.

    No other variable has a name that is ``reserved``.
    """
    inputs = [x.name for x in found.inputs]
    syntax = StructuredText((*reserved, *inputs, *outputs))
    remembered = []
    for k, field in enumerate(found.fields):
        wish = f"previous_{field.name}" if field.name in inputs else field.name
        name = syntax.fields[field.holds] = syntax.names.fresh(wish)
        size = field.size if field.shape else 0
        remembered.append(Variable(name, "LREAL", size, field.start, (field.shape or (1,))[-1]))
        if found.started and found.started[1] == k:
            flag = syntax.fields[found.started[0]] = syntax.names.fresh("started")
            remembered.append(Variable(flag, "BOOL"))
    parts = printed(found, syntax)
    syntax.within["greatest"] = Variable("greatest", "LREAL")
    lines = [
        *_begun(found, remembered, parts.starts, syntax),
        *("(* The largest finite number. *)", f"greatest := {GREATEST};"),
        *("fault := TRUE;", *(f"{output} := 0.0;" for output in outputs)),
        *_left(x.name for x in found.inputs if x.type == REAL),
        *(line.removeprefix("    ") for line in parts.law),
        *(f"{one} := {value};" for one, value in zip(outputs, parts.commands, strict=True)),
        f"fault := {_fault(remembered)};",
    ]
    return Block(syntax.tables, remembered, [*syntax.within.values()], folded(lines))


def _fault(remembered: list[Variable]) -> str:
    """Whether it has stopped itself, where it can."""
    return "tripped > 0.5" if any(x.name == "tripped" for x in remembered) else "FALSE"


def _begun(
    found: Recorded, remembered: list[Variable], starts: dict[str, str], syntax: StructuredText
) -> list[str]:
    """Set what is remembered, at the first sample too where it starts from a table."""
    if not remembered:
        return []
    starting = {syntax.fields[field.holds]: starts.get(field.name) for field in found.fields}
    lines = []
    for one in remembered:
        if one.size:
            value = f"{table}[k]" if (table := starting[one.name]) else "0.0"
            syntax.within["k"] = Variable("k", "DINT")
            lines += [f"    FOR k := 0 TO {one.size - 1} DO", f"        {one.name}[k] := {value};"]
            lines.append("    END_FOR;")
        else:
            first = "FALSE" if one.type == "BOOL" else literal_of(one.first[0])
            lines.append(f"    {one.name} := {first};")
    return ["IF reset THEN", *lines, "END_IF;", ""]
