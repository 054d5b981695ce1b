"""Trees, genes and their evaluation (LL section 3.2)."""

from collections import defaultdict
from itertools import combinations, product

import numpy as np
import oracle
import pytest
from hierarchies import encode, searched_of, valid
from wording import refused

from hfc_design.controllers.genome import taken
from hfc_design.controllers.hierarchical.law import HierarchicalGains, hierarchical
from hfc_design.controllers.hierarchical.record import HierarchicalDesign, layout_of
from hfc_design.controllers.hierarchical.tree import (
    Unit,
    decode,
    reachable,
    trees,
)
from hfc_design.controllers.hierarchical.units import SHARE, _universe, units_that_matter
from hfc_design.core.numbers import SCALARS
from hfc_design.files.loop_setup import load_design

COUNTS = {2: 1, 3: 3, 4: 15, 5: 105, 6: 945}  # (2 i - 3)!!


def shape(node):
    """A nested tree without order: which inputs come together, whatever is column or row."""
    return node if isinstance(node, int) else frozenset(map(shape, node[:2]))


def nested(tree):
    """A ``Tree`` as nested triples with the unit's number in the place of a table."""
    pairs = [(unit.column, unit.row) for unit in tree]
    return oracle.nested(len(tree) + 1, pairs, range(len(tree)))


def all_shapes(leaves):
    """Every way to pair ``leaves`` up, by splitting them in two in every way."""
    if len(leaves) == 1:
        return {leaves[0]}
    found = set()
    for sides in product((0, 1), repeat=len(leaves)):
        left = tuple(leaf for leaf, side in zip(leaves, sides, strict=True) if side)
        right = tuple(leaf for leaf in leaves if leaf not in left)
        if left and right:
            found |= {frozenset(pair) for pair in product(all_shapes(left), all_shapes(right))}
    return found


@pytest.mark.parametrize("inputs", COUNTS)
def test_trees_are_all_the_ways_to_pair_inputs(inputs):
    found = [shape(nested(tree)) for tree in trees(inputs)]
    assert len(found) == COUNTS[inputs]
    assert set(found) == all_shapes(tuple(range(inputs)))


@pytest.mark.parametrize("inputs", COUNTS)
def test_decode_undoes_encode(inputs):
    for tree in trees(inputs):
        assert decode(encode(tree)) == tree


def reduced(gene):
    """The reduction of LL steps 2(ii) and 2(iii), read off the heap from the root; None if invalid.

    A unit is what enters it and what its two children pass on.
    """
    units = 2 ** (len(gene) - 2)

    def passed(unit):
        """What leaves a unit: nothing, one input, or a pair; False where three come together."""
        if unit >= units:
            return None
        parts = [leaf for leaf, place in enumerate(gene) if place == unit]
        for child in (2 * unit + 1, 2 * unit + 2):
            part = passed(child)
            if part is False:
                return False
            if part is not None:
                parts.append(part)
        if len(parts) > 2:
            return False
        return frozenset(parts) if len(parts) == 2 else parts[0] if parts else None

    found = passed(0)
    return None if found is False else found


# The space of genes, counted exhaustively.
@pytest.mark.parametrize(("inputs", "genes", "good"), [(3, 8, 3), (4, 256, 48), (5, 32768, 6300)])
def test_every_gene(inputs, genes, good):
    every = np.array(list(product(range(2 ** (inputs - 2)), repeat=inputs)))
    decoded = [decode(gene) for gene in every.tolist()]
    assert len(decoded) == genes
    assert sum(tree is not None for tree in decoded) == good
    assert [tree is not None for tree in decoded] == valid(every).tolist()
    assert [tree and shape(nested(tree)) for tree in decoded] == [
        reduced(gene) for gene in every.tolist()
    ]
    assert set(decoded) == {None, *trees(inputs)}


# Inputs in the paper's order: e, delta, ddelta/dt, omega_c(t), omega_c(t-1) = 0 .. 4.
E_, DELTA, RATE, NOW, BEFORE = range(5)


def test_structure_of_table_1():
    """omega_c(t), omega_c(t-1) -> 7; (7, delta) -> 3; (3, e) -> 1; (1, ddelta/dt) -> 0."""
    tree = decode([1, 3, 0, 7, 7])
    assert [unit.heap_id for unit in tree] == [7, 3, 1, 0]
    assert tree == (Unit(7, NOW, BEFORE), Unit(3, 5, DELTA), Unit(1, 6, E_), Unit(0, 7, RATE))


def test_structure_of_table_2():
    """(e, omega_c(t-1)) -> 3; (omega_c(t), ddelta/dt) -> 2; (3, delta) -> 1; (1, 2) -> 0."""
    tree = decode([3, 1, 2, 2, 3])
    assert [unit.heap_id for unit in tree] == [3, 2, 1, 0]
    three, two, one, root = tree
    assert three == Unit(3, E_, BEFORE)
    assert {two.column, two.row} == {NOW, RATE}
    assert one == Unit(1, 5, DELTA)
    assert root == Unit(0, 7, 6)


def test_published_designs_have_the_printed_inputs():
    """Input 1 stands over the columns of the paper's tables, input 2 beside the rows."""
    printed = {
        "lin-lee-1999-table-1": [
            (7, "spindle_velocity", "previous_spindle_velocity", 0.4644, 0.4410),
            (3, "unit-7", "deflection", 0.4958, 0.4434),
            (1, "unit-3", "error", 0.4663, 0.4112),
            (0, "unit-1", "deflection_rate", 0.5139, 0.4510),
        ],
        "lin-lee-1999-table-2": [
            (3, "error", "previous_spindle_velocity", 1.5921, 1.5891),
            (2, "spindle_velocity", "deflection_rate", 1.7269, 1.7209),
            (1, "unit-3", "deflection", 1.5474, 1.6924),
            (0, "unit-1", "unit-2", 1.5485, 1.6592),
        ],
    }
    for name, units in printed.items():
        found = load_design(name).controller.units
        assert sorted(
            (
                unit.id,
                unit.column_input,
                unit.row_input,
                unit.consequents[0][1],
                unit.consequents[1][0],
            )
            for unit in found
        ) == sorted(units)


def test_unit_with_one_input_passes_it_on():
    # A alone in unit 2 goes to the root; C and D meet in unit 3, which meets B in unit 1.
    assert decode([2, 1, 3, 3]) == (Unit(3, 2, 3), Unit(1, 4, 1), Unit(0, 5, 0))
    # Figure 5: D reaches B through unit 3 and C the root through unit 2, where three meet.
    assert decode([0, 1, 2, 3]) is None
    assert decode([0, 0, 0]) is None
    assert decode([0, 1, 1]) == (Unit(1, 1, 2), Unit(0, 3, 0))


@pytest.mark.parametrize("gene", [[8, 0, 0, 0, 0], [-1, 0, 0], [0, 2, 1]])
def test_gene_out_of_range_is_refused(gene):
    with refused(ValueError):
        decode(gene)


@pytest.mark.parametrize("inputs", [0, 1, 7])
def test_number_of_inputs_out_of_range_is_refused(inputs):
    with refused(ValueError):
        trees(inputs)
    with refused(ValueError):
        decode([0] * inputs)


@pytest.mark.parametrize(("inputs", "used"), [(4, 2), (5, 3), (6, 4)])
def test_trees_of_some_inputs_are_those_of_every_choice(inputs, used):
    found = defaultdict(list)
    for tree in trees(inputs, used):
        assert all(
            unit.column in columns and unit.row in rows
            for unit, (columns, rows) in zip(tree, reachable(inputs, used), strict=True)
        )
        leaves = sorted(s for unit in tree for s in unit[1:] if s < inputs)
        place = {s: k for k, s in enumerate([*leaves, *range(inputs, inputs + used - 1)])}
        found[tuple(leaves)].append(tuple(Unit(n, place[a], place[b]) for n, a, b in tree))
    assert sorted(found) == list(combinations(range(inputs), used))
    assert all(one == [*trees(used)] for one in found.values())


NAMES = ("error", "deflection", "spindle_velocity", "error_rate")


def population(count=9):
    genome = searched_of(NAMES)
    rng = np.random.default_rng(3)
    found = genome.fresh(rng.integers(genome.structures, size=count), rng)
    tables = found.consequents.copy()
    tables[::3, 0] *= 0.02  # an inner unit that says next to nothing
    tables[1::3, -1] = 0.7  # a root that always says the same
    return genome, found._replace(consequents=tables)


def record_of(genome, one, flat=None):
    data = genome.record(one) | {"sample_time_s": 0.001}
    if flat is not None:
        table = np.array(data["units"][flat]["consequents"])
        data["units"][flat]["consequents"] = np.full((7, 7), table.mean()).tolist()
    return HierarchicalDesign.model_validate(data)


def commands(record):
    law = hierarchical(layout_of(record), record.sample_time_s)
    found = []
    for point in _universe(len(NAMES))[:, :, 0].T:
        pairs = zip(record.inputs, point, strict=True)
        signals = {item.name: u / item.scale for item, u in pairs}
        memory = law.initial_memory(0.0)
        found.append(law.step(SCALARS, record.law_gains(), memory, signals)[0])
    return np.array(found)


def test_a_unit_matters_if_the_command_changes_without_it():
    genome, found = population()
    some = record_of(genome, taken(found, slice(1)))
    counted = units_that_matter(some, genome.gains(found))
    wanted = []
    for k in range(len(found.tree)):
        one = taken(found, slice(k, k + 1))
        own = commands(record_of(genome, one))
        size = np.sqrt(np.mean(own**2))
        without = [commands(record_of(genome, one, flat)) for flat in range(3)]
        wanted.append(sum(np.sqrt(np.mean((own - x) ** 2)) > SHARE * size for x in without))
    assert counted.tolist() == wanted
    assert min(wanted) == 0  # where the root is flat nothing below it is heard
    assert len(set(wanted)) > 2


def test_a_design_has_the_inputs_that_its_tree_reads():
    genome = searched_of(NAMES, used=2)
    assert genome.structures == 6  # 4 over 2
    tree = np.arange(6)
    found = genome.fresh(tree, np.random.default_rng(5))
    whole = hierarchical(layout_of(genome.settings), 0.001)
    for k in tree:
        one = taken(found, slice(k, k + 1))
        record = record_of(genome, one)
        assert [item.name for item in record.inputs] == [
            name for s, name in enumerate(NAMES) if s in genome.trees[k][0][1:]
        ]
        gains = HierarchicalGains(*(x[..., 0] for x in genome.gains(one)[:5]))
        signals = dict(zip(NAMES, (0.03, -0.05, 0.02, 0.04), strict=True))
        own = hierarchical(layout_of(record), 0.001)
        told, wanted = (
            law.step(SCALARS, x, law.initial_memory(0.0), signals)[0]
            for law, x in ((own, record.law_gains()), (whole, gains))
        )
        assert told == pytest.approx(float(wanted), rel=1e-12)
