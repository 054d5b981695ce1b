"""A law that is written for JAX leaves as code through its jaxpr."""

import json
import subprocess
from types import FunctionType
from typing import Any, NamedTuple

import numpy as np
import pytest
from jax import lax
from jax import numpy as jnp

from hfc_design.codegen.javascript import program
from hfc_design.codegen.nodes import TraceError
from hfc_design.codegen.recorded import of_axis, recorded
from hfc_design.controllers.controller import AxisLaw
from hfc_design.core.numbers import finite

RUN = """
{text}
const state = {{ {init} }};
function step(inputs, largest) {{
{law}
    return {command};
}}
console.log(JSON.stringify({errors}.map((error) => step({{ error }}, 1e9))));
"""


class Memory(NamedTuple):
    total: Any


def sample(xp, law, gains, memory, signals):
    error = signals["error"]
    bent = jnp.where(jnp.abs(error) > 1.0, jnp.sin(error), 0.1 * error**3)
    total = lax.fori_loop(0, 7, lambda _, x: 0.9 * x + 0.1 * bent, memory.total)
    return (
        gains[0] * jnp.tanh(error) + total * jnp.sqrt(jnp.maximum(error, 0.0)),
        Memory(total),
        None,
    )


def of_law(function):
    law = AxisLaw(function, lambda law, zero: Memory(zero), 0.01)
    return recorded(of_axis(law, (2.0,), ["error"], None))


def test_it_commands_what_its_formulas_do():
    errors = np.random.default_rng(1).normal(0.0, 2.0, 50).tolist()
    found = program(of_law(sample))
    text = "\n".join([*found.helpers, *found.constants])
    parts = {"init": " ".join(found.init), "law": "\n".join(found.law)}
    run = RUN.format(text=text, command=found.commands[0], errors=errors, **parts)
    done = subprocess.check_output(["node", "-e", run], text=True)
    total, wanted = 0.0, []
    for error in errors:
        bent = np.sin(error) if abs(error) > 1.0 else 0.1 * error**3
        for _ in range(7):
            total = 0.9 * total + 0.1 * bent
        wanted.append(2.0 * np.tanh(error) + total * np.sqrt(max(error, 0.0)))
    np.testing.assert_allclose(json.loads(done), wanted, rtol=1e-13)


@pytest.mark.parametrize(
    ("bad", "names"),
    [
        (lambda x: jnp.linalg.norm(jnp.stack([x, x])), "of arrays"),
        (lambda x: lax.while_loop(lambda y: y < 3.0, lambda y: y + x, x), "while"),
        (jnp.arcsinh, "asinh"),
    ],
)
def test_what_no_printer_knows_is_named_with_file_and_line(bad, names):
    def law(xp, law, gains, memory, signals):
        return bad(signals["error"]), memory, None

    with pytest.raises(TraceError, match=names) as found:
        of_law(law)
    called = law.__code__.co_firstlineno + 1
    line = bad.__code__.co_firstlineno if isinstance(bad, FunctionType) else called
    assert str(found.value).startswith(f"{__file__}:{line}: ")


def test_numbers_of_jax_are_finite_or_not():
    assert finite((jnp.asarray(1.0), 2.0))
    assert not finite({"command": jnp.asarray(jnp.nan)})
