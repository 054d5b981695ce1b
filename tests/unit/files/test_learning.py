"""What a motion has taught a controller: a design that starts the next one."""

import numpy as np
import pytest

import hfc_design.api as hfc
from hfc_design.files.design import with_learned
from hfc_design.runtime import Controller

ROOT = {"controller.adaptation": {"largest_move": 0.8, "k_c": 0.1, "error_scale": 500.0}}


def signals(count, seed=0):
    """Of a C-axis that swings, so that a root learns."""
    random = np.random.default_rng(seed)
    names = ("error", "error_rate", "deflection", "deflection_rate", "spindle_velocity")
    for row in random.normal(0.0, 0.02, (count, len(names))).tolist():
        yield dict(zip(names, row, strict=True))


def test_a_root_goes_on_within_the_bounds_of_its_design():
    design = hfc.load_design("lin-lee-1999-table-1", ROOT)
    whole, machine = Controller(design), Controller(design)
    for k, now in enumerate(signals(400)):
        if k == 200:  # the machine is off for a while; what it learns then begins without a past
            memory = machine._memory
            machine = Controller(with_learned(design, machine.adapted(), {}))
            machine._fresh = False
            machine._memory = machine._memory._replace(
                readings=memory.readings,
                root=memory.root._replace(moves=machine._memory.root.moves),
            )
        assert machine.step(now) == whole.step(now)  # its past was put back
    found = machine.adapted()
    assert found == whole.adapted()
    moves = np.array(found.adaptation.moves)
    assert abs(moves).max() == 0.8  # the bound is that of the design, however often it begins
    assert found.units == design.controller.units
    assert found.tables()[-1] == pytest.approx(np.array(design.controller.tables()[-1]) + moves)
