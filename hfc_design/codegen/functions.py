"""Code of a function of numbers, which is written for JAX: it is traced, and printed."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple, TypeVar

import jax

from hfc_design.codegen.c import C
from hfc_design.codegen.emit import Printer, folded
from hfc_design.codegen.jaxprs import traced
from hfc_design.codegen.nodes import REAL, Node
from hfc_design.codegen.trace import Trace

Key = TypeVar("Key")


class Function(NamedTuple):
    """Body of a function in a language."""

    lines: list[str]
    outputs: dict[str, str]  # destination -> text of its value
    library: list[str]  # functions of the mathematical library
    helpers: list[str]  # names of helper functions that it calls


def recorded(
    function: Callable[..., Any], given: Sequence[Any], named: Callable[[Any], Mapping[Key, Any]]
) -> tuple[Trace, dict[Key, Any]]:
    """Return the recording of ``function``, and its results; see ``printed_function``."""
    trace = Trace()
    nodes = (jax.tree.map(lambda text: trace.leaf("input", text), one) for one in given)
    results = traced(trace, function, *nodes)
    return trace, {key: trace.plain(x) for key, x in named(results).items()}


def printed_function(
    function: Callable[..., Any],
    given: Sequence[Any],
    syntax: type[C],
    taken: Iterable[str],
    named: Callable[[Any], Mapping[str, Any]],
) -> Function:
    """Return the code of ``function``.

    Args:
        function: of trees of numbers.
        given: its arguments, trees with the text of a number in place of each number.
        syntax: language.
        taken: names that the code may not use.
        named: function of the results that returns destination -> number.

    Raises:
        TraceError: there is no code for what the function does.
    """
    trace, values = recorded(function, given, named)
    texts = [str(leaf) for one in given for leaf in jax.tree.leaves(one)]
    language = syntax(taken, dict(zip(texts, texts, strict=True)))
    printer = Printer(trace, language, values.values(), language.names)
    printer.bound |= {x for x in values.values() if isinstance(x, Node) and x.args}
    lines = folded(printer.lines())
    outputs = {key: printer.text(x, kind=REAL) for key, x in values.items()}
    for target, value in outputs.items():  # an output that another one overwrites is copied
        if value in outputs and value != target:
            outputs[target] = printer.names.fresh("before")
            kept = language.form("named", REAL, outputs[target], value=value)
            lines.append(f"    {kept}")
    return Function(lines, outputs, [*language.library], [*language.helpers])
