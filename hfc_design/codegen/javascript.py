"""JavaScript printer of recorded laws, for a page or for Node."""

from collections.abc import Iterable, Iterator, Sequence

from hfc_design.codegen.c import LIBRARY, C
from hfc_design.codegen.language import Language, Printed, printed
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
    "wholePart": (
        "/* The whole part of a number above 0; of others 0. */\n"
        "function wholePart(x) {\n    return x > 0 ? Math.trunc(x) : 0;\n}\n"
    ),
}
#: Names that the module itself uses.
OWN = (
    *("Math", "Number", "Infinity", "NaN", "Float64Array", "Int32Array", "initial", "step"),
    *("signals", "sampleTime", "limit", "wholePart"),
)


class JavaScript(C):
    """JavaScript, see ``Language``."""

    places = {"input": "inputs.", "state": "state."}
    functions = {op: f"Math.{op}" for op in (*LIBRARY, "abs")}
    functions |= {"min": "smaller", "max": "larger", "rint": "nearest", "whole": "wholePart"}
    words = C.words | {"==": "===", "!=": "!=="}
    forms = C.forms | {
        "named": "const {name} = {value};",
        "variable": "let {name} = {value};",
        "declared": "const {name} = new Float64Array({size});",
        "constant": "const {name} = {value!r};",
        "loop": "for (let {name} = {low}; {name} < {high}; {name} += 1) {{",
    }
    helpers_of = HELPERS

    def literal(self, value: float | bool, real: bool) -> str:
        return str(value).lower() if isinstance(value, bool) else repr(value)

    def operation(self, op: str, parts: list[str], node: Node) -> str:
        if op.startswith("as "):
            plain = node.type == WHOLE or op.endswith(WHOLE)
            return parts[0] if plain else f"Number({parts[0]})"
        return Language.operation(self, op, parts, node)

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
        value = values[0] if len(values) == 1 else f"[{', '.join(values)}]"
        ends = [f"    return {value};"] if values else []
        return f"function {name}({', '.join(parameters)})", ends

    def constants(
        self, name: str, kind: str, shape: tuple[int, ...], numbers: Sequence[float]
    ) -> str:
        made = "Float64Array" if kind == REAL else "Int32Array"
        rows = self.rows(kind, shape, numbers)
        return "\n".join(self.folded([f"const {name} = {made}.from([", *rows, "]);"]))


def program(recording: Recorded, reserved: Iterable[str] = ()) -> Printed:
    """Return the code of a law as a module; ``init`` are the members of the memory's object."""
    parts = printed(recording, JavaScript((*OWN, *reserved), {}))
    init = ["started: false,"] if recording.started else []
    for field in recording.fields:
        value = repr(field.start[0])
        if field.shape:
            start = parts.starts.get(field.name)
            value = f"{start}.slice()" if start else f"new Float64Array({field.size})"
        init.append(f"{field.name}: {value},")
    return parts._replace(init=init)
