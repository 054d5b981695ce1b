"""Controllers whose gains are a few numbers, by search: pd and pid."""

import pytest
from resuming import whole_and_in_parts

from hfc_design import api


@pytest.mark.parametrize(
    ("name", "kind", "seconds"), [("c-axis-ramp", "pd", 0.5), ("feed-drive-line", "pid", 1.0)]
)
def test_design_of_gains_ends_with_a_report_and_resumes(
    name, kind, seconds, tmp_path, no_baselines, known_use
):
    scenario = api.load_scenario(
        name,
        {
            "controller": {"kind": kind},
            "search.population": 12,
            "search.generations": 4,
            "simulation.duration_s": seconds,
        },
    )
    files = ("design.json", "history.csv", "report.html")
    whole = whole_and_in_parts(scenario, tmp_path, 2, files)
    assert whole.design == api.design(scenario).design
    assert not (tmp_path / "whole" / "tables").exists()
    page = (tmp_path / "whole" / "report.html").read_text()
    assert f"Gains of the kind {kind}" in page
    gains = getattr(whole.design.controller, kind).model_dump()
    assert all(f"{value:.6g}" in page for value in gains.values())
    with pytest.raises(api.UserError, match="another scenario"):
        api.design(scenario.model_copy(update={"description": "other"}), tmp_path / "parts")


def test_pid_by_search_is_no_worse_than_by_pole_placement():
    """The published gains 1.5, 8.1, 0.1 lie in the ranges; whatever the seed."""
    changes = {"controller": {"kind": "pid"}, "search.population": 32, "search.generations": 8}
    for seed in range(4):
        scenario = api.load_scenario("feed-drive-line", changes | {"run.seed": seed})
        published = api.evaluate(api.load_design("jee-koren-2004-pid"), scenario)
        assert api.design(scenario).evaluation.fitness > published.fitness
