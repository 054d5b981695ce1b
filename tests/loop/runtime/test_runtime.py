"""The numpy runtime against the compiled loop; other designs: tests/published."""

import numpy as np
import pytest
from by_name import random_design, replayed

from hfc_design.files.loop_setup import load_design


def equals_the_loop(design, scenario):
    compiled, found = replayed(design, scenario)
    np.testing.assert_allclose(found, compiled, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("scenario", ["c-axis-ramp", "c-axis-ramp-cutting"])
@pytest.mark.parametrize("name", ["lin-lee-1999-table-1", "pd-only"])
def test_equals_the_loop_on_built_in_designs(name, scenario):
    equals_the_loop(load_design(name), scenario)


def test_equals_the_loop_on_random_designs(random_population):
    for seed in range(3):
        equals_the_loop(random_design(6, seed, random_population), "c-axis-ramp-cutting")
