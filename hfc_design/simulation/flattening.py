"""Inputs of compiled programs: code separate from numbers, many small arrays as few large ones.

Few arrays are used because each one takes time. A *lane* is one individual on one machine.
"""

from collections.abc import Iterable
from typing import Any, NamedTuple

import jax
import numpy as np
from jax.typing import DTypeLike
from jaxtyping import Array, PyTree

from hfc_design.core.numbers import Constant


class Form(NamedTuple):
    """Structure of a packed tree; hashable."""

    structure: Any  # of the tree
    leaves: tuple[tuple[bool, tuple[int, ...]], ...]  # each: is it of integers; shape without lanes


class Code(NamedTuple):
    """A tree without its numbers; hashable, and the key of a compiled program."""

    structure: Any  # of the tree
    leaves: tuple[Any, ...]  # None where a number was


def separate(tree: PyTree) -> tuple[Code, tuple[float, ...]]:
    """Return the code of a tree and its numbers, which are all floats that are no ``Constant``."""
    leaves, structure = jax.tree.flatten(tree)
    data = [isinstance(leaf, float) and not isinstance(leaf, Constant) for leaf in leaves]
    pairs = [*zip(leaves, data, strict=True)]
    code = Code(structure, tuple(None if number else leaf for leaf, number in pairs))
    return code, tuple(leaf for leaf, number in pairs if number)


def joined(code: Code, numbers: Iterable[Any]) -> PyTree:
    """Return the tree that ``separate`` has taken apart, with ``numbers`` in place of its own."""
    rest = iter(numbers)
    return jax.tree.unflatten(
        code.structure, [next(rest) if leaf is None else leaf for leaf in code.leaves]
    )


class Packed(NamedTuple):
    """Packed numbers: (numbers,), or (chunks, numbers, lanes of a chunk) of leaves with lanes."""

    floats: Array | np.ndarray
    integers: Array | np.ndarray


def packed(tree: PyTree, dtype: DTypeLike, chunk: int | None = None) -> tuple[Form, Packed]:
    """Return the form of a tree and its packed numbers, floating-point ones in ``dtype``.

    With ``chunk`` the leaves are (..., lanes); they are divided into chunks of so many lanes.
    """
    leaves, structure = jax.tree.flatten(tree)
    arrays = [np.asarray(leaf) for leaf in leaves]
    whole = [array.dtype.kind == "i" for array in arrays]

    def joined(integers: bool, kind: DTypeLike) -> np.ndarray:
        selected = [array for array, other in zip(arrays, whole, strict=True) if other == integers]
        if chunk is None:
            flat = [np.empty(0, kind), *map(np.ravel, selected)]
            return np.concatenate(flat, dtype=kind, casting="unsafe")
        count = arrays[0].shape[-1] // chunk
        rows = [array.reshape(-1, count, chunk).swapaxes(0, 1) for array in selected]
        buffer = np.empty((count, sum(part.shape[1] for part in rows), chunk), kind)
        begin = 0
        with np.errstate(over="ignore"):  # too large for float32: infinite, the individual fails
            for part in rows:
                buffer[:, begin : (begin := begin + part.shape[1])] = part
        return buffer

    shapes = [array.shape if chunk is None else array.shape[:-1] for array in arrays]
    form = Form(structure, tuple(zip(whole, shapes, strict=True)))
    return form, Packed(joined(False, dtype), joined(True, np.int32))


def unpacked(form: Form, numbers: Packed) -> PyTree:
    """Return the tree from its packed ``numbers``, (numbers,), or (numbers, lanes) of a chunk."""
    leaves, used = [], [0, 0]
    for integers, shape in form.leaves:
        begin = used[integers]
        used[integers] += int(np.prod(shape))
        rows = numbers[integers][begin : used[integers]]
        leaves.append(rows.reshape((*shape, *rows.shape[1:])))
    return jax.tree.unflatten(form.structure, leaves)
