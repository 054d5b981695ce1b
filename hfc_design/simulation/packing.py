"""Many small arrays as few large ones: handing one to a compiled program costs 20 us each."""

from typing import Any, NamedTuple

import jax
import numpy as np
from jax.typing import DTypeLike
from jaxtyping import Array, PyTree


class Form(NamedTuple):
    """What was packed; hashable."""

    structure: Any  # of the tree
    leaves: tuple[tuple[bool, tuple[int, ...]], ...]  # whether of integers, and the shape
    kept: int  # trailing axes that all leaves share


class Packed(NamedTuple):
    """Numbers of a tree, (all, ...) with its shared trailing axes."""

    floats: Array | np.ndarray
    integers: Array | np.ndarray


def packed(tree: PyTree, dtype: DTypeLike, kept: int = 0) -> tuple[Form, Packed]:
    """A tree of numbers; its leaves share ``kept`` trailing axes. Floats come in ``dtype``."""
    leaves, structure = jax.tree.flatten(tree)
    arrays = [np.asarray(leaf) for leaf in leaves]
    whole = [array.dtype.kind == "i" for array in arrays]
    shared = arrays[0].shape[arrays[0].ndim - kept :] if arrays else ()

    def joined(integers: bool, kind: DTypeLike) -> np.ndarray:
        own = [a.reshape(-1, *shared) for a, i in zip(arrays, whole, strict=True) if i == integers]
        return np.concatenate([np.empty((0, *shared), kind), *own], dtype=kind, casting="unsafe")

    form = Form(structure, tuple((i, a.shape) for i, a in zip(whole, arrays, strict=True)), kept)
    return form, Packed(joined(False, dtype), joined(True, np.int32))


def unpacked(form: Form, numbers: Packed) -> PyTree:
    """The tree again; of the shared trailing axes it has as many as ``numbers`` by now."""
    leaves, used = [], [0, 0]
    for integers, shape in form.leaves:
        own = shape[: len(shape) - form.kept]
        begin = used[integers]
        used[integers] += int(np.prod(own))
        rows = numbers[integers][begin : used[integers]]
        leaves.append(rows.reshape((*own, *rows.shape[1:])))
    return jax.tree.unflatten(form.structure, leaves)
