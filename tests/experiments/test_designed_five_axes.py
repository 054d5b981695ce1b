"""The kept controller of five axes on programs that its search has not seen, and a small search."""

import json

import pytest
from click.testing import CliRunner

import hfc_design.api as hfc
from experiments.designed_contours import five_axes
from hfc_design.cli import main

#: A part of the blade, in which all axes move: rapids, the first pass.
PART = "simulation.duration_s=2.5"


@pytest.fixture(scope="module")
def metrics():
    scenario = hfc.load_scenario("five-axis-blade", [PART])
    found = {}
    for name in (five_axes.DESIGNED, "PID of 2009", "compensated of 2009"):
        found[name] = hfc.evaluate(str(five_axes.CONTROLLERS[name]), scenario).metrics
    return found


@pytest.mark.parametrize("other", ["PID of 2009", "compensated of 2009"])
def test_it_beats_the_published_ones_on_the_blade(metrics, other):
    """By far: they lag, it is fed forward."""
    own, against = metrics[five_axes.DESIGNED], metrics[other]
    for key in five_axes.MEASURED:
        assert own[key] < 0.5 * against[key], key
    assert own["rms_contour_error_mm"] < 0.1 * against["rms_contour_error_mm"]
    assert own["limit_share"] == 0.0
    assert own["velocity_share"] < 1.0


def test_its_loops_have_margins_beside_the_delay_that_they_have():
    """Of every axis: gain by half as much again, 25 deg, most of another cycle of delay."""
    path = str(five_axes.CONTROLLERS[five_axes.DESIGNED])
    found = CliRunner().invoke(main, ["stability", path, "--json"])
    assert found.exit_code == 0, found.output
    for own in json.loads(found.stdout)["axes"].values():
        assert own["stable"]
        assert own["gain_up"] > 1.5
        assert own["phase"] > 25.0
        assert own["delay"] > 0.8


@pytest.mark.slow
def test_a_small_search_is_far_ahead_of_the_published_ones_too():
    """Forty generations; nothing of it comes from the kept design."""
    small = {"search.generations": 40, "robust.final": 16, "robust.unseen": 16}
    found = hfc.design(hfc.load_scenario("five-axis-robust", small))
    program = hfc.load_scenario("five-axis-program")
    own = hfc.evaluate(found.design, program).metrics
    published = hfc.evaluate("lin-gai-2009-fuzzy-sliding-compensated", program).metrics
    for key in five_axes.MEASURED:
        assert own[key] < 0.5 * published[key], key
