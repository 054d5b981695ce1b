"""Test vectors are those of the runtime, go beyond every range, and find a wrong number."""

import numpy as np
import pytest
from exported import texts
from flash_folders import ALL, vectors

from hfc_design.formats.flash.tolerance import tolerance


def test_single_precision_is_compared_until_a_decision_is_close():
    """By hand: the last 50 samples of a command of 100 are twice as far off in one of the tries."""
    commands = np.full((1000, 1), 100.0)
    near = commands + 2e-5
    far = commands + 1e-4 * (np.arange(1000) >= 970)[:, None]
    found = tolerance(commands, [near, commands], [far])
    assert found.double == 1e-10
    assert found.single == pytest.approx(8e-5, rel=1e-9)
    assert all(found.alike)  # what is a few times as far off has no other reason
    far[970:] += 0.01
    found = tolerance(commands, [near, commands], [far])
    assert [k for k, alike in enumerate(found.alike) if not alike] == list(range(970, 1000))
    far[400] += 0.01  # all is forgotten before sample 550
    found = tolerance(commands, [near, commands], [far])
    assert sum(found.alike) == 1000 - 150 - 30
    exact = tolerance(commands, [commands], [commands])
    assert exact.single == pytest.approx(2.0**-21 * 100.0)


def test_the_vectors_go_beyond_the_ends_of_the_universe():
    names, numbers, _ = vectors(texts(ALL["lin-lee-1999-table-1"], "c"))
    record = ALL["lin-lee-1999-table-1"].controller
    for item in record.inputs:
        column = numbers[:, names.index(item.name.removeprefix("previous_"))] * item.scale
        assert column.min() < -1.2
        assert column.max() > 1.2
        assert ((np.abs(column) < 0.1) & (column != 0)).sum() > 30
