"""Conversion of functions written for JAX to nodes, through their jaxpr, operation by operation.

It makes code generation possible for drives, which are functions of scalars on ``jax.numpy``, and
for laws that call JAX.
"""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import jax
import numpy as np

from hfc_design.codegen.nodes import INNER as OWN
from hfc_design.codegen.nodes import REAL, Array, Node, TraceError, kind_of
from hfc_design.codegen.recorder import Recorder

#: Operation in JAX -> operation of nodes; first those that have different names.
OPERATIONS = {"add": "+", "sub": "-", "mul": "*", "div": "/"}
OPERATIONS |= {"lt": "<", "le": "<=", "gt": ">", "ge": ">="}
OPERATIONS |= {"eq": "==", "ne": "!=", "round": "rint"}
OPERATIONS |= {
    name: name
    for name in (
        *("neg", "abs", "max", "min", "and", "or", "not", "exp", "expm1", "log", "log1p", "tanh"),
        *("sqrt", "sin", "cos", "tan", "atan", "atan2", "floor", "pow"),
    )
}
#: Operations that do not change a scalar.
NOTHING = frozenset(
    (
        *("convert_element_type", "copy", "stop_gradient", "optimization_barrier", "squeeze"),
        *("broadcast_in_dim", "reshape", "reduce_precision"),
    )
)
INNER = {"pjit", "jit", "closed_call", "custom_jvp_call", "custom_vjp_call", "remat", "checkpoint"}
#: Folders of files between JAX and a user's code; their lines are not reported.
BETWEEN = (*OWN, str(Path(jax.__file__).parent))
#: Largest number of steps of a loop that is unrolled.
FEW = 4


def traced(trace: Recorder, function: Callable[..., Any], *arguments: Any) -> Any:
    """Return the result of a function written for JAX; arguments are trees of nodes and numbers.

    Raises:
        TraceError: the function does something that no code can be generated for; the message names
            the operation.
    """
    leaves, tree = jax.tree.flatten(jax.tree.map(_listed, arguments))
    with jax.enable_x64(True):
        given = [jax.ShapeDtypeStruct((), np.float64)] * len(leaves)
        made, shape = jax.make_jaxpr(
            lambda *values: function(*jax.tree.unflatten(tree, values)), return_shape=True
        )(*given)
    results = _evaluated(trace, made.jaxpr, made.consts, leaves)
    return jax.tree.unflatten(jax.tree.structure(shape), results)


def _listed(value: Any) -> Any:
    """Convert an array to nested lists of its numbers, which JAX accepts."""
    return [_listed(one) for one in value] if isinstance(value, Array) else value


def _evaluated(
    trace: Recorder, jaxpr: Any, consts: Sequence[Any], given: Sequence[Any]
) -> list[Any]:
    known: dict[Any, Any] = dict(zip(jaxpr.constvars, map(_number, consts), strict=True))
    known |= zip(jaxpr.invars, given, strict=True)

    def value(variable: Any) -> Any:
        return _number(variable.val) if hasattr(variable, "val") else known[variable]

    for equation in jaxpr.eqns:
        try:
            result = _done(trace, equation, [value(x) for x in equation.invars])
        except TraceError as error:
            raise error.at(_place(equation)) from None
        known |= zip(equation.outvars, result, strict=True)
    return [value(x) for x in jaxpr.outvars]


def _place(equation: Any) -> str:
    """Return file and line of the code that made an equation; "" if JAX did not keep them."""
    frames = getattr(equation.source_info.traceback, "frames", ())
    others = (one for one in frames if not one.file_name.startswith(BETWEEN))
    return next((f"{one.file_name}:{one.line_num}" for one in others), "")


def _number(value: Any) -> Any:
    """Return a constant of a program, as a number of Python if it is a scalar."""
    return np.asarray(value).item() if np.size(value) == 1 else value


def _done(trace: Recorder, equation: Any, given: list[Any]) -> list[Any]:
    """Record an equation of a jaxpr with the operands ``given``, and return its results."""
    name, params = equation.primitive.name, equation.params
    if name not in INNER and _large(equation):
        raise TraceError(f"calls {name} of arrays, which cannot be exported; write it in scalars")
    rounds = name == "convert_element_type" and not np.issubdtype(params["new_dtype"], np.floating)
    if rounds and kind_of(given[0]) == REAL:
        raise TraceError("converts real numbers to whole ones; write jnp.floor instead")
    if name in NOTHING:
        return given
    if name in INNER:
        inner = params.get("jaxpr") or params.get("call_jaxpr") or params["fun_jaxpr"]
        consts = getattr(inner, "consts", ())
        return _evaluated(trace, getattr(inner, "jaxpr", inner), consts, given)
    if name == "scan":
        return _scanned(trace, params, given)
    if name == "cond":
        return _chosen(trace, params["branches"], given)
    if name in OPERATIONS:
        return [trace.made(OPERATIONS[name], *given)]
    if name not in OTHERS:
        raise TraceError(f"calls {name}, which cannot be exported; write it with other functions")
    return [OTHERS[name](trace.made, params, *given)]


def _large(equation: Any) -> bool:
    return any(x.aval.size > 1 for x in (*equation.invars, *equation.outvars))


def _power(made: Callable[..., Any], x: Any, power: int) -> Any:
    product = x
    for _ in range(abs(power) - 1):
        product = made("*", product, x)
    return product if power > 0 else made("/", 1.0, product)


#: Other operations -> functions of (``Recorder.made``, parameters, operands) that record them.
OTHERS: dict[str, Callable[..., Any]] = {
    "sign": lambda made, params, x: made(
        "?", made(">", x, 0.0), 1.0, made("?", made("<", x, 0.0), -1.0, 0.0)
    ),
    "square": lambda made, params, x: made("*", x, x),
    "integer_pow": lambda made, params, x: _power(made, x, params["y"]),
    "rsqrt": lambda made, params, x: made("/", 1.0, made("sqrt", x)),
    "select_n": lambda made, params, which, a, b: made("?", which, b, a),
    "clamp": lambda made, params, low, x, high: made("min", made("max", x, low), high),
    "logistic": lambda made, params, x: made("/", 1.0, made("+", 1.0, made("exp", made("neg", x)))),
}


def _chosen(trace: Recorder, branches: Sequence[Any], given: list[Any]) -> list[Any]:
    """Record both branches of a condition, and choose each result by the condition."""
    if len(branches) != 2:
        raise TraceError("calls lax.switch, which cannot be exported; write jnp.where instead")
    which, *rest = given
    no, yes = (_evaluated(trace, one.jaxpr, one.consts, rest) for one in branches)
    return [trace.made("?", which, a, b) for a, b in zip(yes, no, strict=True)]


def _scanned(trace: Recorder, params: dict[str, Any], given: list[Any]) -> list[Any]:
    """Record a loop with a known number of steps, in which only the carried values change."""
    inner, length = params["jaxpr"], params["length"]
    count, carried = params["num_consts"], params["num_carry"]
    fixed, carry = given[:count], given[count : count + carried]
    if len(given) > count + carried or len(inner.jaxpr.outvars) > carried:
        raise TraceError("calls lax.scan over arrays, which cannot be exported")

    def step(values: list[Any]) -> list[Any]:
        return _evaluated(trace, inner.jaxpr, inner.consts, [*fixed, *values])

    if length <= FEW:
        for _ in range(length):
            carry = step(carry)
        return carry
    variables = [trace.variable(x) for x in carry]
    with trace.loop(length):
        after = step([trace.now(variable) for variable in variables])
        trace.bound |= {x for x in after if isinstance(x, Node)}
        for variable, x in zip(variables, after, strict=True):
            trace.assign(variable, x)
    return variables
