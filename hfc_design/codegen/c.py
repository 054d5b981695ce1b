"""C99 printer of recorded laws."""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import groupby
from textwrap import wrap
from typing import Any

from hfc_design.codegen.emit import PRODUCT, WIDTH, Printer
from hfc_design.codegen.language import Language, Printed, printed
from hfc_design.codegen.memory import Field
from hfc_design.codegen.nodes import REAL, TRUTH, WHOLE, Call, Function, Node, Storage, kind_of
from hfc_design.codegen.recorded import Recorded

#: Functions that are printed before the law if it needs them.
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
LIBRARY = {
    name: name.upper()
    for name in (
        *("exp", "expm1", "log", "log1p", "tanh", "sqrt", "sin", "cos", "tan", "atan", "atan2"),
        *("floor", "rint", "pow"),
    )
}
TYPES = {REAL: "real", WHOLE: "int", TRUTH: "int"}
#: Names that the generated code itself uses.
OWN = (
    *("real", "R", "LARGEST", "state", "inputs", "largest", "odd", "overflow", "stepped"),
    *("numbers", "count", "before", *HELPERS, *LIBRARY.values()),
)


class C(Language):
    """C99, see ``Language``."""

    types = TYPES
    places = {"input": "inputs->", "state": "state->"}
    functions = CALLED | LIBRARY
    words = {"neg": "-", "not": "!", "and": "&&", "or": "||"}
    forms = {
        "named": "const {type} {name} = {value};",
        "variable": "{type} {name} = {value};",
        "assigned": "{name} = {value};",
        "declared": "real {name}[{size}];",
        "constant": "static const real {name} = R({value!r});",
        "loop": "for (int {name} = {low}; {name} < {high}; {name}++) {{",
        "branch": "if ({condition}) {{",
    }
    helpers_of = HELPERS

    def __init__(self, reserved: Iterable[str], places: Mapping[str, str]) -> None:
        super().__init__((*OWN, *reserved))
        self.elsewhere = places  # C expressions of inputs that are not members of ``inputs``

    def leaf(self, node: Node, name: str) -> str:
        if node.op == "input" and name in self.elsewhere:
            return self.elsewhere[name]
        return super().leaf(node, name)

    def literal(self, value: float | bool, real: bool) -> str:
        return str(int(value)) if isinstance(value, int) else f"R({value!r})"

    def operation(self, op: str, parts: list[str], node: Node) -> str:
        if op.startswith("as "):
            return f"R({parts[0]})" if op.endswith(REAL) else parts[0]
        if op not in self.functions:
            return super().operation(op, parts, node)
        name = self.functions[op]
        if op in CALLED:
            name += "_whole" if node.type != REAL and op != "whole" else ""
            self.helpers[name] = None
        else:
            self.library[op] = None
        return f"{name}({', '.join(map(_bare, parts))})"

    def comment(self, text: str) -> list[str]:
        plain = re.sub(r"[^ -~]|\\\\", "_", text).replace("*/", "* /").replace("/*", "/ *")
        first, *rest = wrap(f"/* {plain} */", WIDTH - 4)
        return [first, *(f" * {line}" for line in rest)]

    def checked(self, text: Callable[..., str], doubtful: list[Any]) -> list[str]:
        zero = self.literal(0.0, True)
        products = " + ".join(f"{zero} * {text(x, PRODUCT + 1)}" for x in doubtful)
        first = self.form("named", REAL, "overflow", value=products)
        return [first, "if (!(overflow <= 0)) {", "    return overflow;", "}"]

    def part(self, array: str, place: str) -> str:
        """Return the part of an array that begins at the index ``place``."""
        return f"{array} + {place}"

    def called(self, printer: Printer, item: Call) -> Iterator[str]:
        args = []
        for x, parameter in zip(item.args, item.function.parameters, strict=True):
            if isinstance(x, tuple):
                storage, place = x
                array = self.array(storage, printer.name(storage))
                begins = isinstance(place, int) and not place
                args.append(array if begins else self.part(array, printer.text(place)))
            else:
                args.append(printer.text(x, kind=kind_of(parameter)))
        filled = sum(isinstance(x, Storage) for x in item.function.results)
        args += [printer.name(x) for x in item.results if isinstance(x, Storage)][:filled]
        numbers = [(x.type, printer.name(x)) for x in item.results if isinstance(x, Node)]
        yield from self.calls(self.names.of(item.function), args, numbers)

    def calls(self, name: str, args: list[str], results: list[tuple[str, str]]) -> Iterator[str]:
        """Yield the lines of a call; a single result is returned, several come through pointers."""
        if len(results) == 1:
            yield self.form("named", *results[0], value=f"{name}({', '.join(args)})")
            return
        for kind, one in results:
            yield f"{TYPES[kind]} {one};"
        yield f"{name}({', '.join([*args, *(f'&{one}' for _, one in results)])});"

    def function(self, recorded: Function) -> str:
        numbers = [x for x in recorded.results if not isinstance(x, Storage)]
        printer = Printer(recorded.trace, self, numbers, self.names)
        printer.commented.add(recorded.what)
        parameters = [self.parameter(x, printer.name(x)) for x in recorded.parameters]
        arrays = [x for x in recorded.results if isinstance(x, Storage)]
        parameters += [self.parameter(x, printer.name(x)) for x in arrays]
        lines = [*printer.lines()]
        kinds = [kind_of(x) for x in numbers]
        values = [printer.text(x, kind=kind_of(x)) for x in numbers]
        wishes = [printer.names.fresh(f"{getattr(x, 'name', '') or 'part'}_out") for x in numbers]
        comment = self.comment(recorded.what) if recorded.what else []
        head, ends = self.defined(self.names.of(recorded), parameters, kinds, values, wishes)
        return "\n".join(self.folded([*comment, head, "{", *lines, *ends, "}", ""]))

    def parameter(self, x: Node | Storage, name: str) -> str:
        """Return the declaration of a parameter; an array that does not change is ``const``."""
        if isinstance(x, Node):
            return f"{TYPES[x.type]} {name}"
        fixed = "" if x.version or x.kind == "result" else "const "
        return f"{fixed}real {name}[{x.size}]"

    def defined(
        self, name: str, parameters: list[str], kinds: list[str], values: list[str], outs: list[str]
    ) -> tuple[str, list[str]]:
        """Return the head of a function, and the lines that return its results."""
        if len(values) == 1:
            head = f"static {TYPES[kinds[0]]} {name}({', '.join(parameters)})"
            return head, [f"    return {values[0]};"]
        parameters += [f"{TYPES[kind]} *{out}" for kind, out in zip(kinds, outs, strict=True)]
        ends = [f"    *{out} = {value};" for out, value in zip(outs, values, strict=True)]
        return f"static void {name}({', '.join(parameters)})", ends

    def constants(
        self, name: str, kind: str, shape: tuple[int, ...], numbers: Sequence[float]
    ) -> str:
        declared = TYPES[kind]
        if kind != REAL and max(map(abs, numbers)) < 128:
            declared = "signed char"
        first = f"static const {declared} {name}[{len(numbers)}] = {{"
        return "\n".join(self.folded([first, *self.rows(kind, shape, numbers), "};"]))


def program(
    recording: Recorded, reserved: Iterable[str] = (), places: Mapping[str, str] | None = None
) -> Printed:
    """Return the code of a controller in C99; none of its names is ``reserved``.

    ``places``: name of an input that is not a member of ``inputs`` -> its C expression.
    """
    parts = printed(recording, C(reserved, places or {}))
    state = []
    for k, field in enumerate(recording.fields):
        if recording.started and recording.started[1] == k:
            state.append("int started; /* whether there was a sample before */")
        state.append(f"{{real}} {field.name}{f'[{field.size}]' if field.shape else ''};")
    init = ["state->started = 0;"] if recording.started else []
    for (count, *_), fields in groupby(
        recording.fields, lambda field: (field.size, *field.shape[:1])
    ):
        init += _begin([*fields], count, parts.starts)
    return parts._replace(state=state, init=init)


def _begin(fields: list[Field], count: int, starts: dict[str, str]) -> list[str]:
    """Return the lines that set ``fields`` of equal size to their start values."""
    if not fields[0].shape:
        return [f"state->{field.name} = {_plain(field.start[0])};" for field in fields]
    first = {
        field.name: f"{starts[field.name]}[k]" if field.name in starts else "0" for field in fields
    }
    lines = (f"    state->{name}[k] = {value};" for name, value in first.items())
    return [f"for (int k = 0; k < {count}; k++) {{", *lines, "}"]


def _plain(x: float) -> str:
    return f"R({x!r})" if x else "0"


def _bare(text: str) -> str:
    """Return an expression without the brackets that enclose all of it, if it has any."""
    if not (text.startswith("(") and text.endswith(")")):
        return text
    depth = 0
    for k, x in enumerate(text):
        depth += (x == "(") - (x == ")")
        if not depth:
            return text[1:-1] if k == len(text) - 1 else text
    return text
