"""Liveness of a recorded function: everything that its results and its memory depend on."""

from collections.abc import Iterable
from itertools import chain
from typing import Any

from hfc_design.codegen.nodes import (
    Assign,
    Block,
    Branch,
    Call,
    Loop,
    Node,
    Statement,
    Storage,
    Store,
)
from hfc_design.codegen.recorder import Recorder

#: Nodes that are printed by their own name wherever they are used.
LEAVES = frozenset(("input", "state", "number", "parameter", "index", "variable", "called"))


def counted(
    trace: Recorder, roots: Iterable[Any], *others: Block
) -> tuple[set[int], dict[Node, list[Block]]]:
    """Return the ids of live nodes, arrays and statements, and the blocks that use each node.

    Live are ``roots``, writes to memory that outlives the function, and whatever these need.
    ``others`` are blocks besides that of the function.
    """
    owners, writers = _written((trace.root, *others))
    alive: set[int] = set()
    uses: dict[Node, list[Block]] = {}
    pending: list[tuple[Any, Block]] = [(root, trace.root) for root in roots]
    for place, statements in writers.items():
        lasts = isinstance(place, Storage) and place.kind in ("state", "parameter", "result")
        if lasts or (isinstance(place, Node) and place.op == "state"):
            pending += statements
    while pending:
        item, block = pending.pop()
        if isinstance(item, Node) and item.op not in LEAVES:
            uses.setdefault(item, []).append(block)
        if not isinstance(item, Node | Storage | tuple) or id(item) in alive:
            continue
        alive.add(id(item))
        if isinstance(item, Node):
            pending += [(x, item.block) for x in item.args]
        if isinstance(item, Node | Storage):
            pending += writers.get(item, ())
            continue
        needed, _ = _flow(item)
        pending += [(x, block) for x in needed]
        while block in owners:
            owner, block = owners[block]
            pending.append((owner, block))
    return alive, uses


def _written(
    blocks: Iterable[Block],
) -> tuple[dict[Block, tuple[Statement, Block]], dict[Any, list[tuple[Statement, Block]]]]:
    """Return the loop or branch of each inner block, and the writers of each array or variable."""
    owners: dict[Block, tuple[Statement, Block]] = {}
    writers: dict[Any, list[tuple[Statement, Block]]] = {}
    pending = [*blocks]
    while pending:
        block = pending.pop()
        for item in block.items:
            if isinstance(item, Loop | Branch):
                owners[item.block] = (item, block)
                pending.append(item.block)
            for place in _flow(item)[1]:
                writers.setdefault(place, []).append((item, block))
    return owners, writers


def _flow(statement: Any) -> tuple[list[Any], tuple[Any, ...]]:
    """Return nodes and arrays that a statement reads, and variables and arrays that it writes."""
    match statement:
        case Branch(condition):
            return [condition], ()
        case Loop(_, low, high):
            return [low, high], ()
        case Assign(variable, value):
            return [variable, value], (variable,)
        case Store(storage, place, value):
            array = [] if isinstance(storage, Node) else [storage]
            return [*array, place, value], (storage,)
        case Call(_, args, results):
            each = (x if isinstance(x, tuple) else (x,) for x in args)
            return [*chain.from_iterable(each), *results], results
    return [], ()
