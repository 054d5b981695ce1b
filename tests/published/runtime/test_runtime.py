"""The numpy runtime: by hand, and against the compiled loop."""

import numpy as np
import pytest
from by_name import random_design, replayed

from hfc_design.controllers.hierarchical.root import Adaptation
from hfc_design.files.loop_setup import load_design


@pytest.mark.parametrize("inputs", [2, 3, 4, 5])
def test_equals_the_loop_on_random_designs(inputs, random_population):
    for seed in range(3):
        design = random_design(inputs, seed, random_population)
        compiled, found = replayed(design, "c-axis-ramp-cutting")
        np.testing.assert_allclose(found, compiled, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize(
    ("name", "scale"), [("lin-lee-1999-table-1", None), ("lin-lee-1999-table-2", 500.0)]
)
def test_equals_the_loop_where_the_root_adapts(name, scale):
    design = load_design(name)
    record = Adaptation(k_c=1e-3, largest_move=0.5, error_scale=scale)
    controller = design.controller.model_copy(update={"adaptation": record})
    adapting = design.model_copy(update={"controller": controller})
    compiled, found = replayed(adapting, "c-axis-ramp-cutting")
    np.testing.assert_allclose(found, compiled, rtol=1e-12, atol=1e-12)
    fixed, found = replayed(design, "c-axis-ramp-cutting")
    np.testing.assert_allclose(found, fixed, rtol=1e-12, atol=1e-12)
    assert np.abs(compiled - fixed).max() > 1.0  # it did learn
