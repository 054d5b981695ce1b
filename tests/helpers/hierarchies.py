"""The genome of a hierarchy for the built-in C-axis, and what Lin & Lee's genes tell of trees."""

import numpy as np

from hfc_design.controllers.hierarchical.genome import HierarchicalGenome
from hfc_design.controllers.hierarchical.record import HierarchicalSettings
from hfc_design.controllers.hierarchical.tree import unit_count
from hfc_design.files.named_scenario import load_scenario


def searched_of(names, search=None, used=None):
    """Of inputs with these names and the scale 10, within the bounds of a search."""
    inputs = [{"name": name, "scale": 10.0} for name in names]
    target = load_scenario("c-axis-ramp").target._replace(bounds=search)
    return HierarchicalGenome(HierarchicalSettings(inputs=inputs, used=used), target)


def encode(tree):
    """The gene that puts every input straight into its unit: ``decode(encode(t)) == t``."""
    inputs = len(tree) + 1
    place = {s: unit.heap_id for unit in tree for s in (unit.column, unit.row) if s < inputs}
    return tuple(place[s] for s in range(inputs))


def valid(genes):
    """Which rows of ``genes`` (n, inputs) decode to a hierarchy, counted for all at once."""
    units = unit_count(genes.shape[1])
    entering = np.stack([(genes == unit).sum(axis=1, dtype=np.int8) for unit in range(units)])
    for unit in range(units - 1, 0, -1):
        entering[(unit - 1) // 2] += entering[unit] > 0
    return np.all(entering <= 2, axis=0)
