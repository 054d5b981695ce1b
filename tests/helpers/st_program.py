"""Runs a program of Structured Text that calls a function block, for tests; as strict as that."""

from lark import Lark
from structured_text import GRAMMAR, FunctionBlock

MORE = {
    '"FUNCTION_BLOCK" NAME': '"PROGRAM" NAME',
    "END_FUNCTION_BLOCK": "END_PROGRAM",
    "type: /BOOL|DINT|INT|LREAL/": "BLOCK: /fb_[a-z0-9_]+/\ntype: /BOOL|DINT|INT|LREAL/ | BLOCK",
    "?statement: ": '?statement: NAME "(" given ("," given)* ")" ";" -> invoke\n    | ',
    "block: ": 'given: NAME ":=" expression\nblock: ',
    "-> name\n": '-> name\n    | NAME "." NAME -> member\n',
}


def _extended():
    text = GRAMMAR
    for old, new in MORE.items():
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    return text


class Program(FunctionBlock):
    """``values`` are its variables; ``cycle()`` runs it once. It calls instances of one block."""

    parser = Lark(_extended(), parser="lalr")

    def __init__(self, text, block_text):
        self.block_text = block_text
        super().__init__(text)

    def cycle(self):
        self.inputs = ["reset"]  # it has none
        self.values.setdefault("command", None)
        self.step()

    def empty(self, kind):
        if not kind.startswith("fb_"):
            return super().empty(kind)
        found = FunctionBlock(self.block_text)
        assert found.block == kind
        return found

    def invoke(self, tree):
        name, *given = tree.children
        block, codes = self.values[name], []
        for item in given:
            to, value = item.children
            kind, code = self.visit(value)
            assert kind == block.kinds[to], to
            codes.append(f"{to}={code}")
        assert {code.partition("=")[0] for code in codes} == set(block.inputs)
        return [f"v['{name}'].step({', '.join(codes)})"]

    def member(self, tree):
        name, part = tree.children
        return self.values[name].kinds[part], f"v['{name}'].values['{part}']"
