"""A law that the root of a hierarchy multiplies: its command by hand, and what tells of it."""

from hfc_design import api


def test_the_page_shows_both_laws(tmp_path):
    small = {"simulation.duration_s": 0.2, "search.population": 6, "search.generations": 4}
    inputs = [{"name": "reference_rate", "scale": 50.0}, {"name": "error", "scale": 3000.0}]
    own = {"inputs": inputs, "linear": {}, "schedules": True, "output_scale": 1.0}
    scenario = api.load_scenario(
        "c-axis-ramp", {"controller": own, "search.preset": "cma", **small}
    )
    found = api.design(scenario, tmp_path / "run").design
    page = (tmp_path / "run" / "report.html").read_text()
    assert "of the scheduled law, which the hierarchy" in page
    assert "scheduled: kp, on the error" in page
    assert f"{found.controller.scheduled.kp:.6g}" in page
    assert "more or less of that law" in page
    assert "The factor on the scheduled law against each scaled input" in page
