"""Controllers whose gains are a few numbers, by search: pd and pid."""

import math

from wording import refused

from hfc_design import api
from plants import FEED_DRIVE


def test_design_by_hand_is_the_published_one():
    scenario = api.load_scenario("feed-drive-circle", {"simulation.duration_s": 4.0})
    by_hand = api.with_gains(scenario, "pid", {"k_p": 1.5, "k_i": 8.1, "k_d": 0.1})
    published = api.load_design("jee-koren-2004-pid")
    assert by_hand.controller == published.controller
    assert math.isclose(
        api.evaluate(by_hand, scenario).fitness, api.evaluate(published, scenario).fitness
    )


CIRCLE = {"reference": {"kind": "circle", "radius_mm": 5.0, "feed_mm_min": 600.0}}


def test_an_own_plant_needs_ranges_inside_too():
    """A machine of one's own, of drives that the package has."""
    api.register(api.side_by_side("own-table", x=FEED_DRIVE, y=FEED_DRIVE))
    each = {"kind": "per-axis", "axes": {axis: {"kind": "pid"} for axis in "xy"}}
    with refused() as found:
        api.load_scenario({"plant": {"name": "own-table"}, "controller": each, **CIRCLE})
    assert "controller.axes.x.ranges" in found.refusal
