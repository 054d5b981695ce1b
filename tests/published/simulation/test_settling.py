"""What is called stable: known limit cycles are not, forced vibration is; the rule by hand."""

import pytest

from hfc_design.files.named_scenario import load_scenario
from hfc_design.simulation.monte_carlo import robustness


@pytest.mark.parametrize(
    ("design", "name"),
    [
        ("lin-lee-1999-table-1", "c-axis-ramp"),
        ("lin-lee-1999-table-2", "c-axis-ramp-cutting"),
        ("pd-only", "c-axis-ramp"),
    ],
)
def test_the_same_machines_are_stable_in_48_substeps(design, name):
    """What is called stable is the loop's and not the step's: one of 100 may be at the border."""
    own, fine = (
        robustness(design, load_scenario(name, ["simulation.duration_s=2", *steps]), 0.2, 100)
        for steps in ([], ["simulation.substeps=48"])
    )
    assert 0 < own.stable.sum() < 100  # there is something to tell apart
    assert (own.stable != fine.stable).sum() <= 1
