"""WebAssembly of functions of numbers: two machines at once, in the lanes of 128-bit registers.

A module of some functions and its memory (WebAssembly core specification 2.0, ch. 5: the binary
format; SIMD instructions). Arguments of a function are addresses of arrays in that memory: of
numbers of two machines, 16 bytes each, or of numbers that both share, 8 bytes each. Truth values
are masks of all bits. exp is computed here, other functions are those of JavaScript's Math.
"""

import struct
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from hfc_design.codegen.functions import recorded
from hfc_design.codegen.live import LEAVES, counted
from hfc_design.codegen.nodes import TRUTH, Assign, Block, Loop, Node, TraceError

#: Codes of types.
I32, F64, V128 = b"\x7f", b"\x7c", b"\x7b"
#: Operation of nodes -> SIMD instruction; of "min" and "max" the first of equal ones, as in laws.
SIMD = {"+": 0xF0, "-": 0xF1, "*": 0xF2, "/": 0xF3, "neg": 0xED, "abs": 0xEC, "sqrt": 0xEF}
SIMD |= {"floor": 0x75, "rint": 0x94, "min": 0xF6, "max": 0xF7, "==": 0x47, "!=": 0x48}
SIMD |= {"<": 0x49, ">": 0x4A, "<=": 0x4B, ">=": 0x4C, "not": 0x4D, "and": 0x4E, "or": 0x50}
#: Other instructions: load and store, of a number for both lanes, constants, lanes, choice, bits.
LOAD, SPLAT, STORE, CONST, LANES_OF = 0x00, 0x0A, 0x0B, 0x0C, 0x14
EXTRACT, REPLACE, CHOOSE, SHIFT, ADD_BITS = 0x21, 0x22, 0x52, 0xCB, 0xCE
GET, SET, TEE = b"\x20", b"\x21", b"\x22"
#: Functions of JavaScript's Math, called once for each lane, and their number of arguments.
MATH = {"expm1": 1, "log": 1, "log1p": 1, "tanh": 1, "sin": 1, "cos": 1, "tan": 1, "atan": 1}
MATH |= {"atan2": 2, "pow": 2}
#: Of exp: range of its argument, ln 2 in two parts, degree of its polynomial, and a number whose
#: last bits count whole numbers that are added to it.
RANGE, LN2, DEGREE, MAGIC = (
    (-746.0, 710.0),
    (6.93147180369123816490e-01, 1.90821492927058770002e-10),
    13,
    6755399441055744.0,
)
LOG2E = 1.4426950408889634


class Argument(NamedTuple):
    """Array that a function gets."""

    name: str
    lanes: bool  # whether it has numbers of two machines


def module(functions: Mapping[str, "Body"]) -> bytes:
    """Return a module that exports functions, and imports ``m.memory`` and from ``m`` functions."""
    imported = [name for name in MATH if any(name in one.called for one in functions.values())]
    types = [_type([F64] * n, [F64]) for n in (1, 2)] + [_type([V128], [V128])]
    types += [_type([I32] * len(one.arguments), []) for one in functions.values()]
    entries = [_text("m") + _text(name) + b"\x00" + _leb(MATH[name] - 1) for name in imported]
    entries.append(_text("m") + _text("memory") + b"\x02\x00\x01")
    first = len(imported) + 1  # the function before it is exp
    exports = [_text(name) + b"\x00" + _leb(first + k) for k, name in enumerate(functions)]
    codes = [_exp(), *(one.code(imported) for one in functions.values())]
    parts = {
        1: types,
        2: entries,
        3: [_leb(2), *(_leb(3 + k) for k in range(len(functions)))],
        7: exports,
        10: [_leb(len(code)) + code for code in codes],
    }
    sections = (bytes([k]) + _sized(_leb(len(x)) + b"".join(x)) for k, x in parts.items())
    return b"\x00asm\x01\x00\x00\x00" + b"".join(sections)


class Body:
    """Code of one function, from its trace."""

    def __init__(
        self,
        function: Callable[..., Any],
        given: Sequence[Any],
        arguments: Sequence[Argument],
        places: Mapping[str, tuple[str, int]],
        named: Callable[[Any], Mapping[tuple[str, int], Any]],
    ):
        """Trace a function.

        Args:
            function: of trees of numbers.
            given: its arguments, trees with a text in place of each number.
            arguments: arrays that the code gets.
            places: text -> name of an array and index in it.
            named: function of the results that returns where each is written -> number.
        """
        self.arguments, self.places = [*arguments], places
        self.trace, self.results = recorded(function, given, named)
        self.alive, self.uses = counted(self.trace, self.results.values())
        self.called = {x.op for x in self.uses if x.op in MATH}
        self.locals: dict[Any, int] = {}
        self.imported: list[str] = []

    def code(self, imported: list[str]) -> bytes:
        """Return the entry of the function in the section of codes."""
        self.locals, self.imported = {}, imported
        body = b"".join(self._block(self.trace.root))
        values = [*self.results.items()]
        ends = []
        for place, x in values:  # all are computed before the first is written
            ends.append(self._real(x) + SET + _leb(self._local(("result", place))))
        for (name, k), _ in values:
            ends.append(self._address(name) + GET + _leb(self._local(("result", (name, k)))))
            ends.append(_simd(STORE) + b"\x03" + _leb(16 * k))
        kinds = [self._kind(thing) for thing in self.locals]
        declared = _leb(len(kinds)) + b"".join(b"\x01" + kind for kind in kinds)
        return declared + body + b"".join(ends) + b"\x0b"

    def _local(self, thing: Any) -> int:
        return len(self.arguments) + self.locals.setdefault(thing, len(self.locals))

    def _kind(self, thing: Any) -> bytes:
        return I32 if isinstance(thing, Node) and thing.op == "index" else V128

    def _address(self, name: str) -> bytes:
        return GET + _leb([one.name for one in self.arguments].index(name))

    def _block(self, block: Block) -> Iterator[bytes]:
        for item in block.items:
            if id(item) not in self.alive:
                continue
            if isinstance(item, Node):
                if not self._inlined(item):
                    yield self._expression(item) + SET + _leb(self._local(item))
            elif isinstance(item, Assign):
                yield self._value(item.value, item.variable.type)
                yield SET + _leb(self._local(item.variable))
            elif isinstance(item, Loop):
                yield from self._loop(item)
            else:
                raise TraceError(f"has a {type(item).__name__}, of which there is no WebAssembly")

    def _loop(self, item: Loop) -> Iterator[bytes]:
        counter = _leb(self._local(item.counter))
        yield b"\x41" + _signed(item.low) + SET + counter + b"\x03\x40"  # loop
        yield from self._block(item.block)
        yield GET + counter + b"\x41\x01\x6a" + TEE + counter + b"\x41" + _signed(item.high)
        yield b"\x48\x0d\x00\x0b"  # again if it is less

    def _inlined(self, node: Node) -> bool:
        uses = self.uses.get(node, [])
        return len(uses) == 1 and uses[0] is node.block and node not in self.trace.bound

    def _real(self, x: Any) -> bytes:
        return self._value(x, "real")

    def _value(self, x: Any, kind: str) -> bytes:
        """Return the code of a value as a number, or as a mask if its ``kind`` is a truth value."""
        if not isinstance(x, Node):
            bits = struct.pack("<q", -bool(x)) if kind == TRUTH else struct.pack("<d", x)
            return _simd(CONST) + 2 * bits
        if x.op == "input":
            name, k = self.places[x.name]
            both = next(one.lanes for one in self.arguments if one.name == name)
            return (
                self._address(name)
                + _simd(LOAD if both else SPLAT)
                + b"\x03"
                + _leb((16 if both else 8) * k)
            )
        if x.op in LEAVES or not self._inlined(x):
            text = GET + _leb(self._local(x))
        else:
            text = self._expression(x)
        if x.type == TRUTH and kind != TRUTH:
            text += _simd(CONST) + 2 * struct.pack("<d", 1.0) + _simd(SIMD["and"])
        return text

    def _expression(self, node: Node) -> bytes:
        op, args = node.op, node.args
        if op == "now":
            return GET + _leb(self._local(args[0]))
        if op == "?":
            chosen = b"".join(self._value(x, node.type) for x in args[1:])
            return chosen + self._value(args[0], TRUTH) + _simd(CHOOSE)
        truth = op in ("and", "or", "not")
        parts = [self._value(x, TRUTH if truth else "real") for x in args]
        if op in SIMD:
            return b"".join(parts) + _simd(SIMD[op])
        if op == "exp":
            return parts[0] + b"\x10" + _leb(len(self.imported))
        if op not in MATH:
            raise TraceError(f"calls {op}, of which there is no WebAssembly")
        held = [self._local(("argument", op, k, node.number)) for k in range(len(parts))]
        code = b"".join(part + SET + _leb(at) for part, at in zip(parts, held, strict=True))
        call = b"\x10" + _leb(self.imported.index(op))
        lanes = [
            b"".join(GET + _leb(at) + _simd(EXTRACT) + bytes([lane]) for at in held) + call
            for lane in (0, 1)
        ]
        return code + lanes[0] + _simd(LANES_OF) + lanes[1] + _simd(REPLACE) + b"\x01"


def _exp() -> bytes:
    """Return the code of exp: 2^n times the power series of the rest, at most ln(2) / 2."""
    x, n, rest = (bytes([k]) for k in range(3))

    def number(value: float) -> bytes:
        return _simd(CONST) + 2 * struct.pack("<d", value)

    def op(name: str) -> bytes:
        return _simd(SIMD[name])

    code = GET + x + number(RANGE[0]) + op("max") + number(RANGE[1]) + op("min") + TEE + x
    code += number(LOG2E) + op("*") + op("rint") + SET + n
    code += GET + x + GET + n + number(LN2[0]) + op("*") + op("-")
    code += GET + n + number(LN2[1]) + op("*") + op("-") + SET + rest
    factorial, terms = 1.0, [1.0]
    for k in range(1, DEGREE + 1):
        factorial *= k
        terms.append(1.0 / factorial)
    code += number(terms[-1])
    for term in reversed(terms[:-1]):
        code += GET + rest + op("*") + number(term) + op("+")
    half = GET + n + number(0.5) + op("*") + op("rint")
    for power in (half + TEE + x, GET + n + GET + x + op("-")):  # so that 2^n may be below 2^-1022
        code += power + number(MAGIC) + op("+") + b"\x41\x34" + _simd(SHIFT)
        code += number(1.0) + _simd(ADD_BITS) + op("*")
    return b"\x01\x02" + V128 + code + b"\x0b"


def _type(given: Iterable[bytes], results: Iterable[bytes]) -> bytes:
    each = (_leb(len(x)) + b"".join(x) for x in ([*given], [*results]))
    return b"\x60" + b"".join(each)


def _simd(code: int) -> bytes:
    return b"\xfd" + _leb(code)


def _text(name: str) -> bytes:
    return _sized(name.encode())


def _sized(content: bytes) -> bytes:
    return _leb(len(content)) + content


def _leb(number: int) -> bytes:
    """Return a whole number from 0 in LEB128."""
    digits = []
    while number > 127:
        digits.append(number & 127 | 128)
        number >>= 7
    return bytes([*digits, number])


def _signed(number: int) -> bytes:
    """Return a number that may be negative in LEB128; here all are from 0."""
    code = bytearray(_leb(number))
    if code[-1] & 64:
        code[-1] |= 128
        code.append(0)
    return bytes(code)
