"""The kept controller of five axes on programs that its search has not seen, and a small search."""

import json

import pytest
from click.testing import CliRunner

import hfc_design.api as hfc
from experiments.designed_contours import five_axes
from hfc_design.cli import main
from hfc_design.runs import run

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


def test_a_small_search_is_far_ahead_of_the_published_ones_too(
    kept, on_the_blade, monkeypatch, known_use
):
    """Ten generations on two machines; nothing of it comes from the kept design."""
    monkeypatch.setattr(run, "used", lambda *_: dict.fromkeys(run.KEPT))  # nobody asks
    sizes = dict.fromkeys(("first", "machines", "elite"), 2) | {"final": 8}
    small = {"search.generations": 10, "search.population": 8}
    small |= {f"robust.{name}": count for name, count in sizes.items()}
    found = hfc.design(hfc.load_scenario("five-axis-robust", small))
    own = on_the_blade(found.design).metrics
    for key in five_axes.MEASURED:
        assert own[key] < 0.5 * kept[OTHERS[-1]].metrics[key], key
