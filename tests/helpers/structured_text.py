"""Runs Structured Text, for tests: a strict subset of IEC 61131-3, written from the standard.

Stricter than compilers are: every name has to be declared once and in one way of writing it, INT,
DINT and LREAL do not mix, an index has to be in its range, inputs and loop variables are read only.
What passes is translated to Python and executed.
"""

import contextlib
import math
from functools import reduce

from lark import Lark
from lark.visitors import Interpreter

GRAMMAR = r"""
start: "FUNCTION_BLOCK" NAME section* statement* "END_FUNCTION_BLOCK"
section: SECTION declaration+ "END_VAR"
declaration: NAME ("," NAME)* ":" type [":=" initial] ";"
type: /BOOL|DINT|INT|LREAL/ | "ARRAY" "[" INTEGER ".." INTEGER "]" "OF" /LREAL|DINT|BOOL/
initial: literal | "[" literal ("," literal)* "]"
literal: SIGN? (REAL | INTEGER) | TRUTH
?statement: NAME ":=" expression ";" -> assign
    | NAME "[" expression "]" ":=" expression ";" -> store
    | "IF" expression "THEN" block _elsif* ["ELSE" block] "END_IF" ";" -> choose
    | "FOR" NAME ":=" expression "TO" expression "DO" block "END_FOR" ";" -> loop
    | "RETURN" ";" -> leave
_elsif: "ELSIF" expression "THEN" block
block: statement+
?expression: both | both ("OR" both)+ -> any
?both: compared | compared ("AND" compared)+ -> all
?compared: "NOT" compared -> inverted | sum (/<=|>=|<>|<|>|=/ sum)?
?sum: product (/[+-]/ product)*
?product: unary (/[*\/]/ unary)*
?unary: _MINUS atom -> negated | atom
?atom: TRUTH -> truth | REAL -> real | INTEGER -> integer | NAME -> name
    | NAME "[" expression "]" -> item | "(" expression ")"
    | FUNCTION "(" expression ("," expression)* ")" -> call
TRUTH.2: /(TRUE|FALSE)(?![A-Za-z0-9_])/
FUNCTION.2: /(ABS|EXP|SQRT|MIN|MAX|BOOL_TO_DINT|(DINT|LINT)_TO_LREAL|LREAL_TO_(DINT|LINT))(?=\()/
SECTION.2: /VAR(_INPUT|_OUTPUT)?(?![A-Za-z0-9_])/
SIGN: "-"
_MINUS: "-"
NAME: /[A-Za-z](_?[A-Za-z0-9])*(?![A-Za-z0-9_])/
REAL.2: /[0-9]+\.[0-9]+(E-?[0-9]+)?/
INTEGER: /[0-9]+/
COMMENT: /\(\*(.|\n)*?\*\)/
%ignore COMMENT
%ignore /\s+/
"""
PARSER = Lark(GRAMMAR, parser="lalr")
#: What each takes and gives; "": any number. A conversion to a whole number is to the nearest.
FUNCTIONS = {
    "ABS": ([""], "", abs),
    "EXP": (["LREAL"], "LREAL", math.exp),
    "SQRT": (["LREAL"], "LREAL", math.sqrt),
    "MIN": (["", ""], "", min),
    "MAX": (["", ""], "", max),
    "BOOL_TO_DINT": (["BOOL"], "DINT", int),
    "DINT_TO_LREAL": (["DINT"], "LREAL", float),
    "LREAL_TO_DINT": (["LREAL"], "DINT", round),
    "LINT_TO_LREAL": (["LINT"], "LREAL", float),
    "LREAL_TO_LINT": (["LREAL"], "LINT", round),
}
EMPTY = {"BOOL": False, "INT": 0, "DINT": 0, "LREAL": 0.0}
WORDS = {"=": "==", "<>": "!="}


class Left(Exception):
    """RETURN."""


class FunctionBlock(Interpreter):
    """``values`` are the variables by name; ``step(**inputs)`` is a call and gives ``command``.

    A statement becomes lines of Python, an expression a pair of its type and Python.
    """

    parser = PARSER

    def __init__(self, text):
        name, *parts = self.parser.parse(text).children
        self.block = str(name)
        self.values, self.kinds, self.inputs, self.inner = {}, {}, [], {}
        for part in parts:
            if part.data == "section":
                self._declare(*part.children)
        self.locked = set(self.inputs)
        lines = [line for part in parts if part.data != "section" for line in self.visit(part)]
        self._code = compile("\n".join(lines), self.block, "exec")

    def step(self, **inputs):
        assert set(inputs) | {"reset"} == set(self.inputs), inputs
        self.values.update({"reset": False} | inputs)
        functions = {name: function for name, (*_, function) in FUNCTIONS.items()}
        with contextlib.suppress(Left):
            exec(self._code, functions | {"v": self.values, "at": _at, "Left": Left})
        return self.values["command"]

    def _declare(self, keyword, *declarations):
        for *names, kind, initial in (declaration.children for declaration in declarations):
            for name in map(str, names):  # a token takes long to compare
                self._declared(keyword, name, kind, initial)

    def _declared(self, keyword, name, kind, initial):
        assert name.casefold() not in map(str.casefold, self.values), f"{name} stands twice"
        *bounds, base = kind.children
        numbers = [_number(base, part) for part in initial.children] if initial else []
        if bounds:
            size = int(bounds[1]) + 1
            assert bounds[0] == "0"
            assert len(numbers) in (0, size), name
            self.values[name] = numbers or [EMPTY[base]] * size
            self.inner[name] = str(base)
        else:
            self.values[name] = numbers[0] if numbers else self.empty(base)
        self.kinds[name] = "ARRAY" if bounds else str(base)
        if keyword == "VAR_INPUT":
            self.inputs.append(str(name))

    def empty(self, kind):
        """What a variable is to begin with."""
        return EMPTY[kind]

    def assign(self, tree):
        name, (kind, code) = tree.children[0], self.visit(tree.children[1])
        assert name not in self.locked, f"{name} is read only"
        assert _same(kind, self.kinds[name]) == self.kinds[name], name
        return [f"v['{name}'] = {code}"]

    def store(self, tree):
        name, index, value = tree.children
        kind, code = self.visit(value)
        assert kind == self.inner[name], name
        return [f"{self._place(name, index)} = {code}"]

    def choose(self, tree):
        *pairs, otherwise = tree.children
        lines = ["if False:", " pass"]
        for condition, block in zip(pairs[::2], pairs[1::2], strict=True):
            kind, code = self.visit(condition)
            assert kind == "BOOL"
            lines += [f"elif {code}:", *self._indented(block)]
        return lines + (["else:", *self._indented(otherwise)] if otherwise else [])

    def loop(self, tree):
        name, low, high, block = tree.children
        assert self.kinds[name] in ("INT", "DINT")
        assert name not in self.locked
        ends = [self.visit(one) for one in (low, high)]
        assert {kind for kind, _ in ends} <= {self.kinds[name], "whole"}
        self.locked.add(name)
        body = self._indented(block)
        self.locked.remove(name)
        return [f"for v['{name}'] in range({ends[0][1]}, {ends[1][1]} + 1):", *body]

    def leave(self, tree):
        return ["raise Left"]

    def _indented(self, block):
        return [f" {line}" for part in block.children for line in self.visit(part)]

    def sum(self, tree):
        first, *rest = tree.children
        kind, code = self.visit(first)
        for operator, part in zip(rest[::2], rest[1::2], strict=True):
            other, right = self.visit(part)
            kind = _same(kind, other)
            assert kind, f"{code} {operator} {right}"
            assert kind != "BOOL" or operator in ("=", "<>"), f"{code} {operator} {right}"
            kind = "BOOL" if operator in ("<", ">", "<=", ">=", "=", "<>") else kind
            code = f"({code} {WORDS.get(operator, operator)} {right})"
        return kind, code

    product = compared = sum

    def all(self, tree):
        kinds, codes = zip(*map(self.visit, tree.children), strict=True)
        assert set(kinds) == {"BOOL"}
        return "BOOL", f"({' and '.join(codes)})"

    def any(self, tree):
        kinds, codes = zip(*map(self.visit, tree.children), strict=True)
        assert set(kinds) == {"BOOL"}
        return "BOOL", f"({' or '.join(codes)})"

    def truth(self, tree):
        return "BOOL", str(tree.children[0]).title()

    def inverted(self, tree):
        kind, code = self.visit(tree.children[0])
        assert kind == "BOOL"
        return kind, f"(not {code})"

    def negated(self, tree):
        kind, code = self.visit(tree.children[0])
        return kind, f"(-{code})"

    def real(self, tree):
        return "LREAL", str(tree.children[0])

    def integer(self, tree):
        return "whole", str(int(tree.children[0]))

    def name(self, tree):
        name = tree.children[0]
        assert self.kinds[name] != "ARRAY"
        return self.kinds[name], f"v['{name}']"

    def item(self, tree):
        return self.inner[tree.children[0]], self._place(*tree.children)

    def _place(self, name, index):
        kind, code = self.visit(index)
        assert self.kinds[name] == "ARRAY"
        assert kind in ("INT", "DINT", "whole")
        return f"v['{name}'][at(v['{name}'], {code})]"

    def call(self, tree):
        function, *arguments = tree.children
        kinds, codes = zip(*map(self.visit, arguments), strict=True)
        wanted, given, _ = FUNCTIONS[function]
        assert len(kinds) == len(wanted)
        assert all(_same(kind, want or kind) for kind, want in zip(kinds, wanted, strict=True))
        found = given or reduce(_same, kinds)
        assert found, function
        return found, f"{function}({', '.join(codes)})"


def _same(one, other):
    """The type of two numbers that are used together, "" where they cannot be."""
    if one == other:
        return one
    for whole, kind in ((one, other), (other, one)):
        if whole == "whole" and kind in ("INT", "DINT"):
            return kind
    return ""


def _number(kind, literal):
    text = "".join(literal.children)
    if text in ("TRUE", "FALSE"):
        assert kind == "BOOL"
        return text == "TRUE"
    assert ("." in text) == (kind == "LREAL")
    return float(text) if kind == "LREAL" else int(text)


def _at(values, index):
    assert 0 <= index < len(values)
    return index
