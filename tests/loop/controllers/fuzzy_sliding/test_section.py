"""The section of the report: the picture of what was learnt is that of the controller."""

import numpy as np
import pytest
from sliding import PID, sliding

from hfc_design.controllers.fuzzy_sliding.section import sections
from hfc_design.controllers.kind import Shown
from hfc_design.pictures.files import image
from plants import FEED_DRIVE, side_by_side


def measured(steps=300):
    k = np.arange(steps)
    return {"error": 20.0 * np.sin(k / 30.0), "error_rate": 300.0 * np.cos(k / 30.0)}


def test_every_axis_has_its_pictures():
    machine = side_by_side(x=FEED_DRIVE, y=FEED_DRIVE)
    shown = Shown(machine, (FEED_DRIVE.parameters(),) * 2, {"x": measured(), "y": measured(2)})
    whole, x, y = sections(sliding(pid=PID).controller, shown)
    assert [part.title for part in (x, y)] == ["What X learns", "What Y learns"]
    rows = {name: (value, unit) for name, value, unit in whole.listing.rows}
    assert rows["slope of the surface, λ"] == ("20", "1/s")
    assert rows["judgement of the error, P₂"] == ("20", "1/s")
    assert rows["beside the rules, k_i"] == ("8", "unit/(BLU s)")
    for part in (whole, x, y):
        for drawing in part.drawings:
            assert image(drawing.figure, "svg").startswith(b"<?xml")


@pytest.mark.parametrize("value", [0.0, 1e300])
def test_nothing_and_far_too_much_can_be_drawn(value):
    shown = Shown(side_by_side(x=FEED_DRIVE), (FEED_DRIVE.parameters(),), None)
    signals = {"error": np.full(3, value), "error_rate": np.full(3, -value)}
    shown = shown._replace(signals={"x": signals})
    *_, learnt = sections(sliding().controller, shown)
    for drawing in learnt.drawings:
        assert image(drawing.figure, "svg")
