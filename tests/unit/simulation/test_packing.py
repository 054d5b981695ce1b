"""Trees of numbers as few arrays."""

import numpy as np

from hfc_design.simulation.packing import packed, unpacked


def test_single_numbers_without_integers():
    form, numbers = packed((2.0, (), np.arange(3.0)), np.float64)
    assert numbers.floats.tolist() == [2.0, 0.0, 1.0, 2.0]
    assert numbers.integers.shape == (0,)
    number, empty, several = unpacked(form, numbers)
    assert (number, empty, several.tolist()) == (2.0, (), [0.0, 1.0, 2.0])
