"""JavaScript of what was recorded, for a page or for Node."""

from collections.abc import Iterable, Iterator, Sequence

from hfc_design.codegen.c import CALLED as C_CALLED
from hfc_design.codegen.c import LIBRARY, C
from hfc_design.codegen.language import Printed, printed
from hfc_design.codegen.nodes import REAL, WHOLE, Node, Storage
from hfc_design.codegen.recorded import Recorded

HELPERS = {
    "smaller": "function smaller(a, b) {\n    return b < a ? b : a;\n}\n",
    "larger": "function larger(a, b) {\n    return b > a ? b : a;\n}\n",
    "nearest": (
        "/* The nearest whole number, of a half the even one. */\n"
        "function nearest(x) {\n"
        "    const up = Math.floor(x + 0.5);\n"
        "    return up - x === 0.5 && up % 2 !== 0 ? up - 1 : up;\n}\n"
    ),
    "whole_part": (
        "/* The whole part of a number above 0; of others 0. */\n"
        "function wholePart(x) {\n    return x > 0 ? Math.trunc(x) : 0;\n}\n"
    ),
}
CALLED = {**C_CALLED, "rint": "nearest"}
WRITTEN = {"whole_part": "wholePart"}
WORDS = {"==": "===", "!=": "!=="}
#: What the module itself calls so.
OWN = (
    *("Math", "Number", "Infinity", "NaN", "Float64Array", "Int32Array", "initial", "step"),
    *("signals", "sampleTime", "limit", "wholePart"),
)


class JavaScript(C):
    """See ``Language``."""

    def leaf(self, node: Node, name: str) -> str:
        place = {"input": "inputs.", "state": "state."}.get(node.op, "")
        return place + name

    def literal(self, value: float | bool, real: bool) -> str:
        return str(value).lower() if isinstance(value, bool) else repr(value)

    def operation(self, op: str, parts: list[str], node: Node) -> str:
        if op.startswith("as "):
            plain = node.type == WHOLE or op.endswith(WHOLE)
            return parts[0] if plain else f"Number({parts[0]})"
        if op in (*LIBRARY, "abs") and op != "rint":
            return f"Math.{op}({', '.join(parts)})"
        if op in CALLED:
            name = CALLED[op]
            self.helpers[name] = None
            return f"{WRITTEN.get(name, name)}({', '.join(parts)})"
        if op in WORDS:
            return f"{parts[0]} {WORDS[op]} {parts[1]}"
        return super().operation(op, parts, node)

    def array(self, storage: Storage, name: str) -> str:
        return f"state.{storage.name}" if storage.kind == "state" else name

    def named(self, kind: str, name: str, value: str) -> str:
        return f"const {name} = {value};"

    def variable(self, kind: str, name: str, value: str) -> str:
        return f"let {name} = {value};"

    def declared(self, name: str, storage: Storage) -> list[str]:
        return [f"const {name} = new Float64Array({storage.size});"]

    def loop(self, k: str, low: str, high: str) -> str:
        return f"for (let {k} = {low}; {k} < {high}; {k} += 1) {{"

    def part(self, array: str, place: str) -> str:
        return f"{array}.subarray({place})"

    def calls(self, name: str, args: list[str], results: list[tuple[str, str]]) -> Iterator[str]:
        call = f"{name}({', '.join(args)});"
        names = [one for _, one in results]
        if len(names) == 1:
            yield f"const {names[0]} = {call}"
        else:
            yield f"const [{', '.join(names)}] = {call}" if names else call

    def parameter(self, x: Node | Storage, name: str) -> str:
        return name

    def defined(
        self, name: str, parameters: list[str], kinds: list[str], values: list[str], outs: list[str]
    ) -> tuple[str, list[str]]:
        found = values[0] if len(values) == 1 else f"[{', '.join(values)}]"
        ends = [f"    return {found};"] if values else []
        return f"function {name}({', '.join(parameters)})", ends

    def constants(
        self, name: str, kind: str, shape: tuple[int, ...], numbers: Sequence[float]
    ) -> str:
        made = "Float64Array" if kind == REAL else "Int32Array"
        rows = self.rows(kind, shape, numbers)
        return "\n".join(self.folded([f"const {name} = {made}.from([", *rows, "]);"]))

    def constant(self, name: str, value: float) -> str:
        return f"const {name} = {value!r};"

    def helper(self, name: str) -> str:
        return HELPERS[name]


def program(found: Recorded, reserved: Iterable[str] = ()) -> Printed:
    """A law as a module; ``init`` are the members of the object that it remembers in."""
    parts = printed(found, JavaScript((*OWN, *reserved), {}))
    init = ["started: false,"] if found.started else []
    for field in found.fields:
        value = repr(field.start[0])
        if field.shape:
            start = parts.starts.get(field.name)
            value = f"{start}.slice()" if start else f"new Float64Array({field.size})"
        init.append(f"{field.name}: {value},")
    return parts._replace(init=init)
