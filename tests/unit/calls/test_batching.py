"""A batch of a script: what its folder holds, and what fails."""

import pytest
from batches import written

import hfc_design.api as hfc

GRID = """
[set]
simulation.duration_s = 0.05
search.population = 4
search.generations = 2
controller.kind = "pd"
[grid]
run.seed = [0, 1, 2]
"""


@pytest.mark.parametrize("workers", [0, -1, 1.5])
def test_processes_that_cannot_be(tmp_path, workers):
    with pytest.raises(hfc.UserError, match=rf"workers={workers}: has to be"):
        hfc.batch(written(tmp_path, GRID), tmp_path / "out", workers=workers)
    assert not (tmp_path / "out").exists()
