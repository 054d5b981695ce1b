"""One object judges closed loops: in searches, in the final choice, in scores and in reports."""

import json

import numpy as np
import pytest
from calm import CALM, LOST, SMALL, TITLE
from resuming import whole_and_in_parts
from run_folders import hfc

from hfc_design import api


def test_an_x_y_machine_is_chosen_by_what_was_searched():
    """Its metrics have no share of sticking, so the share is told from the motion here."""
    changes = {
        "search.stick_penalty": 300.0,
        "search.population": 24,
        "search.generations": 6,
        "simulation.duration_s": 3.0,
        "run.precision": "float64",
        "fitness.settled_after_s": 0.0,  # so that the first samples, from rest, count as stuck
    }
    result = api.design(api.load_scenario("feed-drive-hierarchy", changes))
    best, found = result.search.history.best[-1], result.evaluation
    assert found.merit == pytest.approx(best, rel=1e-9)
    settled, stuck = 0, 0
    for axis in found.axes:
        commanded = abs(axis.happens.reference_rate)
        stuck += np.count_nonzero(abs(axis.velocity) < 0.1 * commanded)
        settled += len(commanded)
    assert stuck > 0
    assert found.merit == pytest.approx(found.fitness / (1 + 300 * stuck / settled), rel=1e-9)


@pytest.mark.parametrize("preset", ["race", "lin-lee-1999"])
def test_a_fitness_below_zero_improves_and_resumes(
    preset, tmp_path, own_plugins, no_baselines, known_use
):
    api.register(CALM)
    changes = {**SMALL, "fitness": {"kind": "calm"}, "search.preset": preset}
    if preset != "race":  # which searches hierarchies
        inputs = {"error": 50.0, "deflection": 80.0, "spindle_velocity": 20.0, "current": 0.1}
        changes["controller"] = {"inputs": [{"name": k, "scale": v} for k, v in inputs.items()]}
        changes["search.generations"] = 20
    scenario = api.load_scenario("c-axis-ramp", changes)
    files = ("design.json", "history.csv", "checkpoint.npz", "report.html")
    whole = whole_and_in_parts(scenario, tmp_path, 3, files)
    history = whole.search.history
    assert history.diverged.sum() > 0 or preset != "race"
    assert history.best[-1] > history.best[0]
    assert (history.median <= history.best).all()
    assert history.best[-1] < 0.0
    state = whole.search.state
    assert np.isfinite(state.score[: len(state.score) // 2]).all()
    own = whole.evaluation
    assert own.fitness == pytest.approx(-1000 * own.metrics["max_error_rad"], rel=1e-9)
    share = own.metrics["stick_share"]
    penalty = scenario.search.stick_penalty
    assert own.merit == pytest.approx(own.fitness * (1 + penalty * share), rel=1e-9)


def test_where_everything_fails_the_run_ends_and_says_so(tmp_path, own_plugins, no_baselines):
    api.register(LOST)
    changes = {**SMALL, "search.generations": 2, "fitness": {"kind": "lost"}}
    with pytest.raises(api.RunError, match="every individual diverged"):
        api.design(api.load_scenario("c-axis-ramp", changes), tmp_path / "run")
    rows = np.genfromtxt(tmp_path / "run" / "history.csv", delimiter=",", names=True)
    assert rows["diverged"].tolist() == [16, 16]
    assert np.isnan(rows["best"]).all()
    assert np.isnan(rows["median"]).all()
    assert not (tmp_path / "run" / "design.json").exists()


def test_commands_and_pages_show_the_merit_under_its_title(tmp_path, no_baselines, known_use):
    small = ("--set", "simulation.duration_s=0.3", "--population", 8, "--generations", 2)
    done = hfc("design", "c-axis-ramp", "--controller", "pd", *small, "--out", tmp_path / "run")
    assert done.exit_code == 0, done.output
    assert f"generation 2/2  {TITLE}: best" in done.stderr
    assert "fitness, LL eq. 5\n" not in done.stdout  # a row, with numbers
    assert "/ (1 + 300 stick share)" in done.stdout
    score = json.loads((tmp_path / "run" / "design.json").read_text())["score"]
    assert score["judged_by"] == TITLE
    found = json.loads(hfc("score", tmp_path / "run", "--json").stdout)
    assert [found[key] for key in score if key != "scenario"] == list(score.values())[1:]
    text = (tmp_path / "run" / "report.html").read_text()
    for part in (
        f"designs are ranked by {TITLE};",
        f'<th scope="row">merit: {TITLE}</th><td class="value">{score["merit"]:.4f}</td>',
        f'<th scope="row">fitness, LL eq. 5</th><td class="value">{score["fitness"]:.4f}</td>',
        f"{TITLE}: the best so far",
    ):
        assert part in text
    plain = hfc("score", tmp_path / "run", "--set", "search.stick_penalty=0").stdout
    assert "stick share)" not in plain
    spread = hfc("score", tmp_path / "run", "--spread", 0.1, "--samples", 4)
    assert f"merit is {TITLE}" in " ".join(spread.stdout.split())
