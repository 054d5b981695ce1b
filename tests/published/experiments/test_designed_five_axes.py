"""The kept controller of five axes on programs that its search has not seen, and a small search."""

import json

import pytest
from click.testing import CliRunner

import hfc_design.api as hfc
from experiments.designed_contours import five_axes
from hfc_design.cli import main

OTHERS = ("PID of 2009", "compensated of 2009")


@pytest.fixture(scope="module")
def on_the_blade():
    """What a controller does on rapids and the first blocks of the blade."""
    scenario = hfc.load_scenario("five-axis-blade", ["simulation.duration_s=2.5"])
    return lambda name: hfc.evaluate(str(five_axes.CONTROLLERS[name]), scenario)


@pytest.fixture(scope="module")
def designed(on_the_blade):
    return on_the_blade(five_axes.DESIGNED)


@pytest.mark.parametrize("other", OTHERS)
def test_it_beats_the_published_ones_in_every_measure(designed, on_the_blade, other):
    """Of the PID by far, contour and orientation together too."""
    found = on_the_blade(other)
    own, against = designed.metrics, found.metrics
    for key in five_axes.MEASURED:
        assert own[key] < 0.5 * against[key], key
    assert own["rms_contour_error_mm"] < 0.1 * against["rms_contour_error_mm"]
    assert own["limit_share"] == 0.0
    assert own["velocity_share"] < 1.0
    assert other != OTHERS[0] or designed.fitness > 4.0 * found.fitness


def test_its_loops_have_margins_beside_the_delay_that_they_have():
    """Of every axis: gain by half as much again, 20 deg, most of another cycle of delay."""
    path = str(five_axes.CONTROLLERS[five_axes.DESIGNED])
    found = CliRunner().invoke(main, ["stability", path, "--json"])
    assert found.exit_code == 0, found.output
    for own in json.loads(found.stdout)["axes"].values():
        assert own["stable"]
        assert own["gain_up"] > 1.5
        assert own["phase"] > 20.0
        assert own["delay"] > 0.7


def test_a_small_search_is_far_ahead_of_the_published_ones_too():
    """Twenty generations; nothing of it comes from the kept design."""
    small = {"search.generations": 20, "search.population": 8, "robust.final": 16}
    small |= {"robust.unseen": 16}
    found = hfc.design(hfc.load_scenario("five-axis-robust", small))
    program = hfc.load_scenario("five-axis-program")
    own = hfc.evaluate(found.design, program).metrics
    published = hfc.evaluate("lin-gai-2009-fuzzy-sliding-compensated", program).metrics
    for key in five_axes.MEASURED:
        assert own[key] < 0.5 * published[key], key
