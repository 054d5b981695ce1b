"""How many units matter, against the runtime's own law one point at a time."""

import numpy as np
from hierarchies import searched_of

from hfc_design.controllers.genome import taken
from hfc_design.controllers.hierarchical.law import hierarchical
from hfc_design.controllers.hierarchical.record import HierarchicalDesign, layout_of
from hfc_design.controllers.hierarchical.units import SHARE, _universe, units_that_matter
from hfc_design.core.numbers import SCALARS

NAMES = ("error", "deflection", "spindle_velocity", "error_rate")


def population(count=12):
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
        found.append(law.step(SCALARS, record.gains(), memory, signals)[0])
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


def test_the_universe_fills_the_cube():
    points = _universe(5)
    assert points.shape == (5, 128, 1)
    assert np.abs(points.mean(axis=1)).max() < 0.05
    assert np.abs(points).max() <= 1.0


def test_beside_a_large_linear_part_no_unit_matters():
    genome, found = population()
    loud = found._replace(gains=1e6 * np.ones_like(found.gains))
    some = record_of(genome, taken(found, slice(1)))
    assert units_that_matter(some, genome.gains(loud)).max() == 0
    silent = found._replace(gains=np.zeros_like(found.gains))
    alone = units_that_matter(some, genome.gains(silent))
    assert (alone >= units_that_matter(some, genome.gains(found))).all()
