"""A hierarchy on a linear part: its law by hand, what tells of it, what a search makes of it."""

import json

import pytest
from resuming import whole_and_in_parts
from scheduled import SMALL, on_linear
from sledge import hfc

from hfc_design import api
from hfc_design.files.design import design_json


def test_stopped_and_resumed_equals_uninterrupted(tmp_path, no_baselines, known_use):
    whole = whole_and_in_parts(on_linear(**{"search.preset": "race"}), tmp_path, 4)
    page = (tmp_path / "whole" / "report.html").read_text()
    assert "Gains of the linear part" in page
    assert "feed-forward of Coulomb friction" in page
    assert "Each loop of the simulation opened at its command" in page
    assert f"{whole.design.controller.linear.ki:.6g}" in page


FEED = {
    "kind": "pd+hierarchical-fuzzy",
    "inputs": [
        {"name": "error", "scale": 0.1},
        {"name": "error_rate", "scale": 0.01},
        {"name": "reference_rate", "scale": 0.01},
    ],
    "output_scale": 5.0,
    "linear": {},
}


@pytest.mark.parametrize("own", [False, True])
def test_a_feed_drive_with_a_part_for_both_axes_or_one_each(own, tmp_path):
    controller = {"kind": "per-axis", "axes": {"x": FEED, "y": FEED}} if own else FEED
    small = SMALL | {"simulation.duration_s": 1.0, "search.generations": 2}
    scenario = api.load_scenario("feed-drive-circle", {"controller": controller, **small})
    design = api.design(scenario).design
    parts = design.by_axis()
    assert len(parts) == (2 if own else 1)
    assert all(part.controller.linear is not None for part in parts.values())
    (tmp_path / "design.json").write_text(design_json(design))
    found = json.loads(hfc("stability", tmp_path / "design.json", "--json").stdout)
    assert {one["axis"] for one in found["points"]} == {"x", "y"}
