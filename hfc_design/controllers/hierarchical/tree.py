"""Hierarchies of two-input fuzzy units: trees, the genes that encode them, their evaluation.

A hierarchy of i inputs is a full binary tree with i leaves and i - 1 units. It is held as data,
so that one compiled program serves all of them: a ``Tree`` lists its units in evaluation order,
each with the source of its column and of its row input. Source s < i is external input s;
source i + k is the output of the k-th unit of the list.
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
    """Unit of a tree: its place in the heap and the sources of its two inputs."""

    heap_id: int
    column: int
    row: int


Tree = tuple[Unit, ...]
#: Column and row source of each unit (units,).
Sources: TypeAlias = Sequence[tuple[Scalar, Scalar]] | NDArray[np.int32]
#: Possible sources (column, row) of each unit.
Reach: TypeAlias = Sequence[tuple[Sequence[int], Sequence[int]]]

# While a tree is being built: a leaf is the number of an input, a node is (column, row).
Node = Any


def unit_count(inputs: int) -> int:
    """Number of units that genes of ``inputs`` inputs can name: U = 2^(i-2) (LL section 3.2)."""
    if not 2 <= inputs <= MAX_INPUTS:
        raise ValueError(f"inputs must be 2 to {MAX_INPUTS} (got {inputs})")
    return int(2 ** (inputs - 2))


@cache
def trees(inputs: int, used: int | None = None) -> tuple[Tree, ...]:
    """Return every distinct hierarchy of ``inputs`` inputs, or of ``used`` ones among them.

    The order is always the same. For i inputs there are (2i - 3)!!: 1, 3, 15, 105, 945 for 2 to 6.
    """
    unit_count(inputs)
    some = combinations(range(inputs), used or inputs)
    return tuple(_flatten(node, inputs) for leaves in some for node in _nodes(leaves))


def _nodes(leaves: tuple[int, ...]) -> Iterator[Node]:
    """Yield all canonical nodes over ``leaves``; the first leaf always stays on the kept side."""
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
    """Return a node with inputs in canonical order: more leaves first, then the smaller leaf."""

    def key(node: Node) -> tuple[int, int]:
        leaves = _leaves(node)
        return (-len(leaves), min(leaves))

    return tuple(sorted((one, other), key=key))


def _leaves(node: Node) -> list[int]:
    return [node] if isinstance(node, int) else _leaves(node[0]) + _leaves(node[1])


def _flatten(root: Node, inputs: int) -> Tree:
    """Return the units of ``root``, deepest heap place first, so that inputs precede their use."""
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
    """Return the hierarchy encoded by ``gene``, or None if it is invalid.

    ``gene[s]`` names the heap unit that input s enters. From the highest unit down, a unit
    without inputs vanishes and one with a single input passes it on to its parent; afterwards
    every unit has to have exactly two (LL section 3.2, steps 2(ii) and 2(iii)).
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
    """Return a tree as nested pairs (column input, row input).

    ``names`` are those of the inputs, ``sources`` the column and row source of each unit.
    """
    values = [name.replace("_", " ") for name in names]
    for column, row in sources:
        values.append(f"({values[column]}, {values[row]})")
    return values[-1]


@cache
def all_sources(inputs: int, used: int | None = None) -> NDArray[np.int32]:
    """Return every tree as data for the closed loop: sources (trees, units, 2), column first."""
    return np.array([[unit[1:] for unit in tree] for tree in trees(inputs, used)], dtype=np.int32)


@cache
def reachable(inputs: int, used: int | None = None) -> Reach:
    """Return the sources that units have in any of the trees, in order.

    They are little more than half of all earlier sources: a column has no fewer leaves than its
    row.
    """
    sources = all_sources(inputs, used)
    columns, rows = ([tuple(np.unique(unit).tolist()) for unit in side] for side in sources.T)
    return tuple(zip(columns, rows, strict=True))
