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
    return lambda design: hfc.evaluate(design, scenario)


@pytest.fixture(scope="module")
def kept(on_the_blade):
    """Of the kept controller and of the published ones, by their names."""
    names = (five_axes.DESIGNED, *OTHERS)
    return {name: on_the_blade(str(five_axes.CONTROLLERS[name])) for name in names}


@pytest.mark.parametrize("other", OTHERS)
def test_it_beats_the_published_ones_in_every_measure(kept, other):
    """Of the PID by far, contour and orientation together too."""
    designed, found = kept[five_axes.DESIGNED], kept[other]
    own, against = designed.metrics, found.metrics
    for key in five_axes.MEASURED:
        assert own[key] < 0.5 * against[key], key
    assert own["rms_contour_error_mm"] < 0.1 * against["rms_contour_error_mm"]
    assert own["limit_share"] == 0.0
    assert own["velocity_share"] < 1.0
    assert other != OTHERS[0] or designed.fitness > 4.0 * found.fitness


def test_its_loops_have_margins_beside_the_delay_that_they_have():
    """Of every axis at the fastest move; Z has the least of them."""
    path = str(five_axes.CONTROLLERS[five_axes.DESIGNED])
    found = CliRunner().invoke(
        main, ["stability", path, "--scenario", "five-axis-robust", "--json"]
    )
    assert found.exit_code == 0, found.output
    moving = [one for one in json.loads(found.stdout)["points"] if "why" not in one]
    assert {one["axis"] for one in moving} == set("xyzac")
    for own in moving:
        assert own["stable"]
        z = own["axis"] == "z"
        assert own["gain_up"] > (1.3 if z else 1.7)
        assert own["phase_deg"] > (15.0 if z else 30.0)
        assert own["delay_samples"] > (0.45 if z else 1.1)
