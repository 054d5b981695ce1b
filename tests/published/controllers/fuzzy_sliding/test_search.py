"""The genome: it begins with the start, keeps to its ranges, and is the design that it writes."""

from hfc_design import api
from hfc_design.files.named_scenario import load_scenario

CIRCLE = {"controller": {"kind": "fuzzy-sliding"}, "limits.command": 120.0}


def test_a_search_ends_with_a_design_that_learns(tmp_path, no_baselines, known_use):
    changes = {"search.population": 16, "search.generations": 3, "simulation.duration_s": 4.0}
    scenario = load_scenario("feed-drive-circle", CIRCLE | changes)
    result = api.design(scenario, tmp_path / "run")
    assert result.evaluation.metrics["rms_contour_error_BLU"] < 2.0
    page = (tmp_path / "run" / "report.html").read_text()
    assert "Learning of Y" in page
