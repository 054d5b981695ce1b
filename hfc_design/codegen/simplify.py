"""Simplification of operations by what is known before a design runs."""

from collections.abc import Callable
from typing import Any

from hfc_design.codegen.nodes import TRUTH, WHOLE, Node

#: Operation -> function of known numbers.
KNOWN: dict[str, Callable[..., Any]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "<": lambda a, b: a < b,
    "<=": lambda a, b: a <= b,
    ">": lambda a, b: a > b,
    ">=": lambda a, b: a >= b,
    "==": lambda a, b: a == b,
    "!=": lambda a, b: a != b,
    "neg": lambda a: -a,
    "abs": abs,
}


def value_of(op: str, args: tuple[Any, ...]) -> Any:
    """Return the result of an operation if all its operands are known; else None."""
    numbers = [known(x) for x in args]
    return None if op not in KNOWN or None in numbers else KNOWN[op](*numbers)


def simpler(op: str, args: tuple[Any, ...]) -> Any:
    """Return a value equal to an operation in every bit but the sign of 0; None if none is known.

    Inputs and memory count as finite, because otherwise the sample has no command.
    """
    if op == "whole" and isinstance(args[0], Node) and args[0].type == WHOLE:
        return args[0]
    if op in ("min", "max") and all(map(_literal, args)):
        return (min if op == "min" else max)(args)
    if op == ">" and isinstance(args[0], Node) and args[0].type == TRUTH and args[1] == 0.5:
        return args[0]
    if op in ("and", "or") and any(isinstance(x, bool) for x in args):
        a, b = args if isinstance(args[0], bool) else args[::-1]
        return b if a == (op == "and") else a
    if op == "?":
        return _chosen(*args)
    return _added(op, *args) if op in ("+", "-", "*", "/") else None


def _chosen(condition: Any, a: Any, b: Any) -> Any:
    if (holds := known(condition)) is not None:
        return a if holds else b
    return a if a is b or (_literal(a) and _literal(b) and a == b) else None


def _added(op: str, a: Any, b: Any) -> Any:
    left, right = known(a), known(b)
    if op == "*" and ((left == 0.0 and _finite(b)) or (right == 0.0 and _finite(a))):
        return 0.0
    if right == (1.0 if op in ("*", "/") else 0.0) and not _literal(a):
        return a
    neutral = {"*": 1.0, "+": 0.0}.get(op)
    if neutral is None or left != neutral or _literal(b):
        return None
    return b if b.type != TRUTH else None  # adding it makes it a number


def _literal(x: Any) -> bool:
    return not isinstance(x, Node)


def known(x: Any) -> float | None:
    """Return the value of a number, or None if it is known at run time only."""
    return x.value if isinstance(x, Node) else x


def _finite(x: Any) -> bool:
    if not isinstance(x, Node) or x.value is not None:
        return True
    if x.op in ("neg", "abs", "?", "min", "max"):
        return all(map(_finite, x.args[x.op == "?" :]))
    return x.op in ("input", "state", "whole", "index")
