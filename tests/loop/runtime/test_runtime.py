"""The numpy runtime against the compiled loop; other designs: tests/published."""

import numpy as np
import pytest
from by_name import random_design, replayed

from hfc_design.files.pairing import load_design


@pytest.mark.parametrize("name", ["lin-lee-1999-table-1", "pd-only", "six inputs"])
def test_equals_the_loop(name, random_population):
    of_names = name in ("lin-lee-1999-table-1", "pd-only")
    seeds = [] if of_names else range(3)
    designs = [load_design(name)] if of_names else []
    for design in designs + [random_design(6, seed, random_population) for seed in seeds]:
        for scenario in ("c-axis-ramp", "c-axis-ramp-cutting"):
            compiled, found = replayed(design, scenario)
            np.testing.assert_allclose(found, compiled, rtol=1e-12, atol=1e-12)
