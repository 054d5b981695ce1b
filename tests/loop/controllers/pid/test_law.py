"""The PID controller: by hand."""

import math

import pytest
from wording import refused

from hfc_design import api
from hfc_design.controllers.controller import AxisLaw
from hfc_design.controllers.pid import PidGains, initial_memory, sample
from hfc_design.core.numbers import SCALARS
from hfc_design.files.design import design_json
from hfc_design.files.loop_setup import load_design
from hfc_design.runtime import Controller
from plants import FEED_DRIVE


def test_an_error_within_the_dead_zone_counts_as_0():
    """By hand: 2, which no other was before, then 1 and -1 as 0, then -3."""
    design = load_design("jee-koren-2004-pid", {"controller.dead_zone": 1.0})
    controller = Controller(design)
    found = [controller.step({"error": error}) for error in (2.0, 1.0, -1.0, -3.0)]
    integral = 8.1 * 0.01
    assert found == pytest.approx(
        [3.0 + 2 * integral, 2 * integral - 20.0, 2 * integral, -4.5 - integral - 30.0]
    )


def test_a_design_without_a_dead_zone_does_not_name_it():
    assert "dead_zone" not in design_json(load_design("jee-koren-2004-pid"))
    with refused() as found:
        load_design("jee-koren-2004-pid", {"controller.dead_zone": -1})
    assert "controller.dead_zone = -1" in found.refusal


def test_law_by_hand():
    law = AxisLaw(sample, initial_memory, 0.01)
    memory = law.initial_memory(0.0)
    gains = PidGains(1.5, 8.1, 0.1)
    first, memory = law.step(SCALARS, gains, memory, {"error": 2.0})
    assert first == pytest.approx(1.5 * 2 + 8.1 * 0.01 * 2 + 0.1 * 2 / 0.01)
    second, _ = law.step(SCALARS, gains, memory, {"error": 1.0})
    assert second == pytest.approx(1.5 * 1 + 8.1 * 0.01 * 3 - 0.1 * 1 / 0.01)


def test_design_by_hand_is_the_published_one():
    scenario = api.load_scenario("feed-drive-circle", {"simulation.duration_s": 4.0})
    by_hand = api.with_gains(scenario, "pid", {"k_p": 1.5, "k_i": 8.1, "k_d": 0.1})
    published = api.load_design("jee-koren-2004-pid")
    assert by_hand.controller == published.controller
    assert math.isclose(
        api.evaluate(by_hand, scenario).fitness, api.evaluate(published, scenario).fitness
    )


CIRCLE = {"reference": {"kind": "circle", "radius_mm": 5.0, "feed_mm_min": 600.0}}


def test_an_own_plant_needs_ranges_inside_too(own_plugins):
    """A machine of one's own, of drives that the package has."""
    api.register(api.side_by_side("own-table", x=FEED_DRIVE, y=FEED_DRIVE))
    each = {"kind": "per-axis", "axes": {axis: {"kind": "pid"} for axis in "xy"}}
    with refused() as found:
        api.load_scenario({"plant": {"name": "own-table"}, "controller": each, **CIRCLE})
    assert "controller.axes.x.ranges" in found.refusal
