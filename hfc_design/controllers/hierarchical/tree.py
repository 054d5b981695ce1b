"""Hierarchies of two-input fuzzy units: trees, and the genes that encode trees.

A hierarchy of i inputs is a full binary tree with i leaves and i - 1 units. A tree is data, not
code, so that one compiled program serves all trees: a ``Tree`` lists the units in the order of
their evaluation, each with a source of its column input and a source of its row input. A source
s < i is external input s; a source i + k is the output of unit k of the list, counted from 0.
"""

from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from itertools import combinations
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from hfc_design.core.numbers import Scalar

MAX_INPUTS = 6


class Unit(NamedTuple):
    """Unit of a tree, with two sources. In the heap, units 2n+1 and 2n+2 feed unit n (root: 0)."""

    heap_id: int
    column: int
    row: int


Tree = tuple[Unit, ...]
#: For each unit (column source, row source): (units, 2).
Sources: TypeAlias = Sequence[tuple[Scalar, Scalar]] | NDArray[np.int32]
#: For each unit the possible sources of its column input, and those of its row input.
Reach: TypeAlias = Sequence[tuple[Sequence[int], Sequence[int]]]

# Part of a tree: a leaf is the number of an input, a unit is a pair of parts (column, row).
Node = Any


def unit_count(inputs: int) -> int:
    """Return U = 2^(i-2): a gene of i ``inputs`` has units 0 to U - 1 (LL section 3.2)."""
    if not 2 <= inputs <= MAX_INPUTS:
        raise ValueError(f"inputs must be 2 to {MAX_INPUTS} (got {inputs})")
    return int(2 ** (inputs - 2))


@cache
def trees(inputs: int, used: int | None = None) -> tuple[Tree, ...]:
    """Return each distinct tree of ``inputs`` inputs, or of any choice of ``used`` among them.

    The order is always the same. For i = 2 to 6 inputs there are (2i - 3)!! = 1, 3, 15, 105, 945.
    """
    unit_count(inputs)
    some = combinations(range(inputs), used or inputs)
    return tuple(_flatten(node, inputs) for leaves in some for node in _nodes(leaves))


def _nodes(leaves: tuple[int, ...]) -> Iterator[Node]:
    """Yield each distinct node over ``leaves`` once: no split moves the first leaf to ``rest``."""
    if len(leaves) == 1:
        yield leaves[0]
        return
    first, others = leaves[0], leaves[1:]
    for size in range(len(others)):
        for chosen in combinations(others, size):
            rest = tuple(leaf for leaf in others if leaf not in chosen)
            for one in _nodes((first, *chosen)):
                for other in _nodes(rest):
                    yield _joined(one, other)


def _joined(one: Node, other: Node) -> Node:
    """Return a pair: first the part with more leaves, or, if equal, with the smallest leaf."""

    def key(node: Node) -> tuple[int, int]:
        leaves = _leaves(node)
        return (-len(leaves), min(leaves))

    return tuple(sorted((one, other), key=key))


def _leaves(node: Node) -> list[int]:
    return [node] if isinstance(node, int) else _leaves(node[0]) + _leaves(node[1])


def _flatten(root: Node, inputs: int) -> Tree:
    """Return the units of node ``root`` by falling heap number, so that each follows its inputs."""
    placed: list[tuple[int, Node]] = []

    def place(node: Node, heap_id: int) -> None:
        if not isinstance(node, int):
            placed.append((heap_id, node))
            place(node[0], 2 * heap_id + 1)
            place(node[1], 2 * heap_id + 2)

    place(root, 0)
    placed.sort(key=lambda item: -item[0])
    order = {heap_id: inputs + k for k, (heap_id, _) in enumerate(placed)}
    return tuple(
        Unit(n, order.get(2 * n + 1, node[0]), order.get(2 * n + 2, node[1]))  # a unit, or a leaf
        for n, node in placed
    )


def decode(gene: Sequence[int]) -> Tree | None:
    """Return the hierarchy encoded by ``gene``; None if a unit would have more than two inputs.

    ``gene[s]`` is the heap number of the unit that input s enters. From the highest number down,
    a unit without inputs is removed, and a unit with one input passes it on to its parent; every
    remaining unit must have exactly two inputs (LL section 3.2, steps 2(ii) and 2(iii)).
    """
    inputs = len(gene)
    units = unit_count(inputs)
    if not all(0 <= unit < units for unit in gene):
        raise ValueError(f"a gene of {inputs} inputs must have units 0 to {units - 1} (got {gene})")
    entering: list[list[Node]] = [[] for _ in range(units)]
    for leaf, unit in enumerate(gene):
        entering[unit].append(leaf)
    for unit in range(units - 1, -1, -1):
        nodes = entering[unit]
        if len(nodes) > 2:
            return None
        passed = _joined(*nodes) if len(nodes) == 2 else nodes[0] if nodes else None
        if unit == 0:
            return _flatten(passed, inputs)
        if passed is not None:
            entering[(unit - 1) // 2].append(passed)
    raise AssertionError("unit 0 is always reached")


def notation(names: Sequence[str], sources: Iterable[tuple[int, int]]) -> str:
    """Return the text of a tree: nested pairs (column input, row input).

    ``names`` are the names of the inputs; ``sources`` has column and row source of each unit.
    """
    values = [name.replace("_", " ") for name in names]
    for column, row in sources:
        values.append(f"({values[column]}, {values[row]})")
    return values[-1]


@cache
def all_sources(inputs: int, used: int | None = None) -> NDArray[np.int32]:
    """Return the sources of all ``trees`` for the closed loop: (trees, units, 2), column first."""
    return np.array([[unit[1:] for unit in tree] for tree in trees(inputs, used)], dtype=np.int32)


@cache
def reachable(inputs: int, used: int | None = None) -> Reach:
    """Return for each unit the sources that it has in any of ``trees``, in ascending order.

    They are little more than half of all inputs and earlier units, because the column input of a
    unit never has fewer leaves than the row input.
    """
    sources = all_sources(inputs, used)
    columns, rows = ([tuple(np.unique(unit).tolist()) for unit in side] for side in sources.T)
    return tuple(zip(columns, rows, strict=True))
