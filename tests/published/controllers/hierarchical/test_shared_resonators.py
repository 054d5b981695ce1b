"""Resonators beside a hierarchy, alone and shared with the law that its root multiplies."""

from hfc_design import api
from hfc_design.runs.individuals import genome_of


def test_a_search_moves_them(tmp_path, no_baselines):
    """All stages of cma of two laws, and the page at its end."""
    own = {
        "inputs": [{"name": name, "scale": 50.0} for name in ("reference_rate", "error")],
        "linear": {"load_frequencies_rad_s": [1.0, 50.0]},
        "schedules": True,
    }
    small = {"simulation.duration_s": 0.2, "search.population": 8, "search.generations": 6}
    changes = {"controller": own, "search.preset": "cma", **small}
    scenario = api.load_scenario("c-axis-ramp-cutting", changes)
    genome = genome_of(scenario)
    (first,) = genome.gains(genome.empty()).linear.resonators[:1, 0, 0]
    found = api.design(scenario, tmp_path / "run").design.controller
    assert found.linear.resonators[0].in_phase not in (0.0, first)
    page = (tmp_path / "run" / "report.html").read_text()
    assert f"{found.linear.resonators[1].quadrature:.6g}" in page
    assert "scheduled: resonator of 50 rad/s, a quarter turn ahead" in page
