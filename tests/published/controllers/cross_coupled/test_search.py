"""The cross-coupled controller in the loop: simulated, searched, shown."""

import pytest

import hfc_design.api as hfc
from hfc_design.runs.individuals import genome_of

SHORT = {"simulation.duration_s": 4.0, "search.generations": 3, "search.population": 16}
PID = {"kind": "pid", "ranges": {"k_p": [0.1, 4.0], "k_i": [0.0, 1.0]}}
SETTINGS = {"kind": "cross-coupled", "inner": {"kind": "per-axis", "axes": {"x": PID, "y": PID}}}


@pytest.fixture(scope="module")
def found():
    scenario = hfc.load_scenario("feed-drive-circle", {**SHORT, "controller": SETTINGS})
    return scenario, hfc.design(scenario)


def test_a_search_varies_what_is_inside_and_its_own(found):
    scenario, result = found
    own = result.design.controller
    assert 0.1 <= own.inner.axes["x"].pid.k_p <= 4.0
    assert own.inner.axes["x"] != own.inner.axes["y"]
    assert 0.1 <= own.contour.k_p <= 20.0
    assert list(own.feed_forward) == ["x", "y"]
    assert 0.0 <= own.feed_forward["y"] <= 0.1
    again = hfc.evaluate(result.design, scenario)
    assert again.fitness == pytest.approx(result.evaluation.fitness, rel=1e-12)
    assert genome_of(scenario).notation(0) == "x: pid, y: pid"
