"""Trees of numbers as few arrays."""

import jax
import numpy as np

from hfc_design.simulation.flattening import packed, unpacked

TREE = {
    "table": np.arange(24.0).reshape(2, 3, 4),
    "sources": np.array([[5, 6, 7, 8]], np.int64),
    "none": None,
    "gain": np.array([1.5, 2.5, 3.5, 4.5]),
}


def test_chunks_of_what_was_packed():
    form, numbers = packed(TREE, np.float32, 2)
    assert numbers.floats.shape == (2, 7, 2)
    assert numbers.floats.dtype == np.float32
    assert numbers.integers.tolist() == [[[5, 6]], [[7, 8]]]
    for k in range(2):
        own = jax.tree.map(lambda leaf, k=k: leaf[k], numbers)
        found = jax.jit(unpacked, static_argnums=0)(form, own)
        wanted = jax.tree.map(lambda leaf, k=k: leaf[..., 2 * k : 2 * k + 2], TREE)
        jax.tree.map(np.testing.assert_array_equal, found, wanted)


def test_single_numbers_without_integers():
    form, numbers = packed((2.0, (), np.arange(3.0)), np.float64)
    assert numbers.floats.tolist() == [2.0, 0.0, 1.0, 2.0]
    assert numbers.integers.shape == (0,)
    number, empty, several = unpacked(form, numbers)
    assert (number, empty, several.tolist()) == (2.0, (), [0.0, 1.0, 2.0])
