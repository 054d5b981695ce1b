"""A scenario without a controller, on a machine that the default one does not fit."""

import pytest

from hfc_design.core.records import UserError
from hfc_design.files.named_scenario import load_scenario

MOVE = {
    "name": "move",
    "plant": {"name": "positioning-stage"},
    "reference": {"kind": "step", "height": 0.5},
    "simulation": {"duration_s": 0.1},
}


def test_a_controller_that_is_named_has_to_fit_at_once():
    with pytest.raises(UserError, match="'deflection' is no signal of the positioning-stage"):
        load_scenario(MOVE | {"controller": {"kind": "pd+hierarchical-fuzzy"}})
