"""Machines within tolerances: a Latin hypercube, tolerances of single parameters."""

import numpy as np

from hfc_design.files.machine import PlantSettings
from hfc_design.simulation.machines import drawn

FEED = PlantSettings(name="feed-drive")


def shares(machines, name):
    """How far a parameter of each machine but the nominal one is from that, as a share of it."""
    (axis,) = machines.true
    values = getattr(axis, name)
    return values[1:] / values[0] - 1.0


def test_a_latin_hypercube_meets_every_part_of_every_range_once():
    machines, refused = drawn(FEED, 0.2, 50, 3, even=True)
    assert refused == 0
    for name in machines.true[0]._fields:
        if getattr(machines.true[0], name)[0] == 0.0 or name in FEED.machine.drives[0].exact:
            continue
        parts = np.floor((shares(machines, name) + 0.2) / 0.4 * 50)
        assert sorted(parts) == list(range(50)), name
