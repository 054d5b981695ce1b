"""WebAssembly of functions in Node, in both lanes: what NumPy computes."""

import jax.numpy as jnp
import numpy as np
import pytest
from jax import lax
from wasm_node import in_node

from hfc_design.codegen.wasm import Argument, Body, module

NUMBERS = np.array([-708.3, -40.0, -2.5, -1.5, -0.0, 0.0, 1e-9, 0.5, 0.7, 1.0, 3.5, 36.0, 709.0])
PAIRS = np.array([(x, y) for x in (-2.5, -1.0, 0.0, 0.5, 3.0) for y in (-1.0, 0.0, 0.5, 2.5)])
#: Functions of two numbers, and whether each is exact to the last bit.
FUNCTIONS = {
    "arithmetic": (lambda x, y: (x - y) * (x + 2.0 * y) / (3.0 + x * x), True),
    "exp": (lambda x, y: jnp.exp(x * y), False),
    "small": (lambda x, y: jnp.exp(-300.0 * x * x - 30.0 * y), False),
    "tanh": (lambda x, y: jnp.tanh(x) * y, False),
    "angle": (lambda x, y: jnp.arctan2(x, y) + jnp.sin(x), False),
    "power": (lambda x, y: jnp.abs(x) ** (y + 1.25), False),
    "chosen": (lambda x, y: jnp.where((x < y) | ~(x >= 0.5), jnp.minimum(x, y), -y), True),
    "rounded": (lambda x, y: jnp.round(x) + jnp.floor(y) + jnp.sign(x * y), True),
    "counted": (lambda x, y: (x > 0.0) + 2.0 * ((x > 0.0) & (y == 0.5)), True),
    "root": (lambda x, y: jnp.sqrt(jnp.abs(x)) - jnp.maximum(x, y), True),
}


def compiled(function):
    """A module with ``f(x, y, z)``: x of two machines, y shared."""
    places = {"x": ("x", 0), "y": ("y", 0)}
    arguments = [Argument("x", True), Argument("y", False), Argument("z", True)]
    return module({"f": Body(function, ["x", "y"], arguments, places, lambda z: {("z", 0): z})})


def computed(program, function, pairs, folder):
    """Results of both lanes, the second with the opposite of x."""
    memory = np.zeros((len(pairs), 6))
    memory[:, 0], memory[:, 1], memory[:, 2] = pairs[:, 0], -pairs[:, 0], pairs[:, 1]
    calls = [["f", 48 * k, 48 * k + 16, 48 * k + 32] for k in range(len(pairs))]
    after = in_node(program("node"), compiled(function), memory.ravel(), calls, folder)
    return after.reshape(-1, 6)[:, 4:]


@pytest.mark.parametrize("name", FUNCTIONS)
def test_both_lanes_compute_what_numpy_does(program, name, tmp_path):
    function, exact = FUNCTIONS[name]
    found = computed(program, function, PAIRS, tmp_path)
    x, y = PAIRS[:, :1] * [1.0, -1.0], PAIRS[:, 1:] * [1.0, 1.0]
    wanted = np.asarray(function(x, y))
    if exact:
        np.testing.assert_array_equal(found, wanted)
    else:
        np.testing.assert_allclose(found, wanted, rtol=4e-15)


def test_exp_is_within_two_units_of_the_last_place_and_ends_as_it_should(program, tmp_path):
    pairs = np.stack([np.append(NUMBERS, np.linspace(-745.0, 709.7, 3001)), np.zeros(3014)], 1)
    found = computed(program, lambda x, y: jnp.exp(x + y), pairs, tmp_path)[:, 0]
    wanted = np.exp(pairs[:, 0])
    assert (np.abs(found - wanted) <= 2.0 * np.spacing(wanted)).all()
    ends = np.array([[800.0, 0.0], [np.nan, 0.0], [np.inf, 0.0]])
    found = computed(program, lambda x, y: jnp.exp(x + y), ends, tmp_path)
    np.testing.assert_array_equal(found, [[np.inf, 0.0], [np.nan, np.nan], [np.inf, 0.0]])


def test_a_loop_repeats_its_steps(program, tmp_path):
    """Newton's steps for a square root, twenty of them."""

    def root(x, y):
        number = jnp.abs(x) + 1.0
        return lax.fori_loop(0, 20, lambda _, r: 0.5 * (r + number / r) + 0.0 * y, number)

    found = computed(program, root, PAIRS, tmp_path)
    wanted = np.sqrt(np.abs(PAIRS[:, :1] * [1.0, -1.0]) + 1.0)
    np.testing.assert_allclose(found, wanted, rtol=1e-15)
