"""Of a motion of few samples nobody can say that a loop settles in it."""

import numpy as np
import pytest

from hfc_design.files.named_scenario import load_scenario
from hfc_design.objectives.judge import Judged
from hfc_design.simulation.acceptance import motion_result, units
from hfc_design.simulation.stability_criteria import STABILITY


@pytest.mark.parametrize(("duration", "passes"), [(0.079, False), (0.08, True)])
def test_a_motion_of_fewer_than_80_samples_is_not_passed(duration: float, passes: bool):
    """Ten samples in each half of its last quarter, where all that is measured is 0."""
    scenario = load_scenario("c-axis-ramp", {"simulation.duration_s": duration})
    values = np.zeros((3, 1, len(units(scenario)) + len(STABILITY)))
    still = Judged(np.ones((3, 1)), values, np.zeros((3, 1), bool))
    assert (motion_result(scenario, still, 0, scenario).nominal_reasons == ()) == passes
