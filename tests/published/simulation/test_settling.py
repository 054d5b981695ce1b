"""What is called stable: known limit cycles are not, forced vibration is; the rule by hand."""

import pytest

from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.pairing import load_design
from hfc_design.simulation.comparing import compare
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


def test_a_comparison_says_why_a_design_is_not_stable():
    """Of a gain half as large again, which swings."""
    sharp = ["controller.pd.kp=1137", "controller.pd.kd=1114.5"]
    designs = {"calm": load_design("pd-only"), "sharp": load_design("pd-only", sharp)}
    scenario = load_scenario("c-axis-ramp", ["simulation.duration_s=3", "limits.command=60"])
    found = compare(designs, scenario, spread=0.01, machines=3)
    (note,) = [line for line in found.notes if "stable" in line]
    told = "nominal machine swings; of 3 others 3 swing, 3 are far off"
    assert note == f"sharp in c-axis-ramp, not stable: {told}"
    alone = robustness(designs["sharp"], scenario, 0.01, 3)
    assert alone.numbers()["reasons"] == {"swings": 3, "is far off": 3}
    assert alone.numbers()["nominal_reasons"] == ["swings"]
