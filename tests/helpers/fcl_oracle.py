"""A reader of function blocks in FCL with COGS and PROD, independent of the package.

The grammar is that of IEC 61131-7 as far as such a block needs it; ``GAUSS2`` and the place of
``ACCU`` in a rule block are jFuzzyLogic's, which unites singletons of one value (its ``COGS``).
"""

import re
from collections import Counter
from math import prod

import lark
import numpy as np

GRAMMAR = r"""
start: "FUNCTION_BLOCK" NAME "VAR_INPUT" real+ "END_VAR" "VAR_OUTPUT" real "END_VAR" \
    fuzzify+ defuzzify block "END_FUNCTION_BLOCK"
real: NAME ":" "REAL" ";"
fuzzify: "FUZZIFY" NAME term+ "END_FUZZIFY"
term: "TERM" NAME ":=" (point+ | GAUSS2 NUMBER NUMBER NUMBER NUMBER) ";"
point: "(" NUMBER "," NUMBER ")"
GAUSS2: "GAUSS2"
defuzzify: "DEFUZZIFY" NAME single+ accu? "METHOD" ":" "COGS" ";" default "END_DEFUZZIFY"
single: "TERM" NAME ":=" NUMBER ";"
accu: "ACCU" ":" SUM ";"
SUM: "BSUM" | "SUM"
default: "DEFAULT" ":=" NUMBER ";"
block: "RULEBLOCK" NAME "AND" ":" "PROD" ";" "ACT" ":" "PROD" ";" accu? rule+ "END_RULEBLOCK"
rule: "RULE" INT ":" "if" NAME "is" NAME "and" NAME "is" NAME "then" NAME "is" NAME ";"
NAME: /[A-Za-z_][A-Za-z0-9_]*/
NUMBER: /[+-]?\d+\.\d+(E-?\d+)?/
%import common.INT
%import common.WS
%ignore WS
%ignore /\(\*(.|\n)*?\*\)/
"""
PARSER = lark.Lark(GRAMMAR, parser="lalr", maybe_placeholders=False)


class Block:
    """A function block in a file."""

    def __init__(self, file):
        text = file.read_text()
        tree = PARSER.parse(text)
        self.default = float(next(tree.find_data("default")).children[0])
        self.terms = {}
        for name, body in re.findall(r"FUZZIFY (\w+)\n(.*?)END_FUZZIFY", text, re.DOTALL):
            for label, shape in re.findall(r"TERM (\w+) := (.*);", body):
                self.terms[name, label] = shape
        singles = list(tree.find_data("single"))
        self.singles = {str(s.children[0]): float(s.children[1]) for s in singles}
        self.rules = [[str(c) for c in rule.children[1:]] for rule in tree.find_data("rule")]
        (accu,) = tree.find_data("accu")
        bounded = accu.children[0] == "BSUM"
        self.united = not bounded
        counts = Counter(name for name, _ in self.terms)
        assert len(self.rules) == prod(counts.values())
        assert set(self.singles) == {rule[-1] for rule in self.rules}
        assert len(singles) == len(self.singles)

    def evaluate(self, **inputs):
        """Output for arrays of the inputs."""
        degrees = {
            (name, label): self.degree(shape, inputs[name])
            for (name, label), shape in self.terms.items()
            if name in inputs
        }
        at = {}  # firing of a singleton, or of all those with one value
        for row, row_term, column, column_term, _, single in self.rules:
            firing = degrees[row, row_term] * degrees[column, column_term]
            value = self.singles[single]
            key = value, None if self.united else single
            at[key] = at.get(key, 0.0) + firing
            assert self.united or (at[key] <= 1.0 + 1e-12).all(), "a bounded sum is no sum here"
        weights = sum(at.values())
        weighted = sum(value * firing for (value, _), firing in at.items())
        return np.where(weights > 0.0, weighted / np.where(weights > 0.0, weights, 1), self.default)

    @staticmethod
    def degree(shape, x):
        """Straight lines, constant beyond the ends; or two halves of Gaussians."""
        numbers = [float(number) for number in re.findall(r"[-+]?\d+\.\d+(?:E-?\d+)?", shape)]
        if shape.startswith("GAUSS2"):
            low, left, high, right = numbers
            rising = np.exp(-0.5 * (np.minimum(x - low, 0.0) / left) ** 2)
            return rising * np.exp(-0.5 * (np.maximum(x - high, 0.0) / right) ** 2)
        assert numbers[0::2] == sorted(set(numbers[0::2]))
        return np.interp(x, numbers[0::2], numbers[1::2])
