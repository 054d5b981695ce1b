"""MATLAB and Octave printer of recorded laws: one function, with arrays that begin at 1."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

from hfc_design.codegen.emit import WIDTH, Printer, folded
from hfc_design.codegen.language import Language, Printed, larger, printed
from hfc_design.codegen.nodes import REAL, TRUTH, WHOLE, Branch, Loop, Node, Storage
from hfc_design.codegen.recorded import Recorded

#: Names that the function itself uses or calls; i and j are numbers in MATLAB.
OWN = (
    *("signals", "state", "command", "abs", "all", "cos", "double", "exp", "floor", "isempty"),
    *("isfinite", "max", "min", "sin", "sqrt", "tanh", "true", "false", "zeros", "NaN", "Inf", "i"),
    "j",
)


class Matlab(Language):
    """MATLAB and Octave, see ``Language``."""

    chooses = frozenset(("?",))
    places = {"input": "signals.", "state": "state."}
    words = {"neg": "-", "not": "~", "and": "&&", "or": "||", "!=": "~="}
    forms = dict.fromkeys(("named", "variable", "assigned"), "{name} = {value};") | {
        "declared": "{name} = zeros(1, {size});",
        "constant": "{name} = {value!r};",
        "loop": "for {name} = {low}:{last}",
        "branch": "if {condition}",
    }
    end = {Loop: "end", Branch: "end"}

    def leaf(self, node: Node, name: str) -> str:
        truth = node.op == "input" and node.type == TRUTH
        return super().leaf(node, name) + " > 0.5" * truth

    def literal(self, value: float | bool, real: bool) -> str:
        return str(value).lower() if isinstance(value, bool) else repr(value)

    def operation(self, op: str, parts: list[str], node: Node) -> str:
        if op.startswith("as "):
            return parts[0] if node.type == WHOLE else f"double({parts[0]})"
        if op == "rint":  # to the nearest whole number, a half to the even one
            return f"(floor({parts[0]} + 0.5) - (mod({parts[0]}, 2) == 0.5))"
        if op == "whole":
            return f"floor(max({parts[0]}, 0))"
        if op.isalnum() and op not in self.words:
            return f"{op}({', '.join(parts)})"
        return super().operation(op, parts, node)

    def value(self, printer: Printer, node: Node) -> Iterator[str]:
        if node.op not in self.chooses:
            yield from super().value(printer, node)
            return
        condition, *values = node.args
        a, b = (printer.text(x, kind=node.type) for x in values)
        name = printer.name(node)
        if larger(condition, *values):
            yield f"{name} = max({a}, {b});"
            return
        yield from (f"if {printer.text(condition)}", f"    {name} = {a};", "else")
        yield from (f"    {name} = {b};", "end")

    def element(self, storage: Storage, name: str, place: str) -> str:
        place = str(int(place) + 1) if place.isdigit() else f"{place} + 1"
        return f"{self.array(storage, name)}({place})"

    def comment(self, text: str) -> list[str]:
        plain = "".join(x if " " <= x <= "~" else "_" for x in text)
        return [f"% {plain}"]

    def checked(self, text: Callable[..., str], doubtful: list[Any]) -> list[str]:
        values = ", ".join(map(text, doubtful))
        return [f"if ~all(isfinite([{values}]))", "    return;", "end"]

    def constants(
        self, name: str, kind: str, shape: tuple[int, ...], numbers: Sequence[float]
    ) -> str:
        written = [self.literal(bool(x) if kind == TRUTH else x, kind == REAL) for x in numbers]
        rows = (written[k : k + shape[-1]] for k in range(0, len(written), shape[-1]))
        lines = [f"    {', '.join(row)}, ..." for row in rows]
        return "\n".join(self.folded([f"{name} = [ ...", *lines, "];"]))

    def folded(self, lines: Iterable[str]) -> list[str]:
        result: list[str] = []
        for line in lines:
            plain = line.lstrip().startswith("%")
            parts = [line] if plain or len(line) <= WIDTH else folded([line])
            result += [f"{part} ..." for part in parts[:-1]] + parts[-1:]
        return result


def program(recording: Recorded, reserved: Iterable[str] = ()) -> Printed:
    """Return the code of a law as a function; ``init`` are the lines that set its memory."""
    parts = printed(recording, Matlab((*OWN, *reserved)))
    init = ["state.started = false;"] if recording.started else []
    for field in recording.fields:
        value = repr(field.start[0])
        if field.shape:
            value = parts.starts.get(field.name) or f"zeros(1, {field.size})"
        init.append(f"state.{field.name} = {value};")
    return parts._replace(init=init)
