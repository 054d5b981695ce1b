"""The positioning stage against hand calculations in SI units and SciPy with events."""

import pytest

from hfc_design.files.machine import PlantSettings
from plants.positioning_stage import (
    POSITIONING_STAGE,
)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"mass": 0.0}, "parameters.mass = 0.0: has to be more than zero"),
        ({"coulomb_friction": -1.0}, "parameters.coulomb_friction = -1.0: has to be zero or more"),
        ({"viscous_asymmetry": 1.0}, "viscous_asymmetry = 1.0: has to be between -1 and 1"),
        ({"inertia": 1.0}, "parameters.inertia: unknown; there is"),
    ],
)
def test_impossible_stage_is_named(changes, message):
    assert message in POSITIONING_STAGE.fault(changes)
    with pytest.raises(ValueError, match="parameters"):
        PlantSettings(name="positioning-stage", parameters=changes)
    assert POSITIONING_STAGE.fault({"coulomb_friction": 0.0, "offset": 99.0}) is None
