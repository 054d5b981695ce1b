"""The search of a feed drive's fuzzy controllers: its genome, and what comes out of it."""

import pytest
from feed_genomes import CIRCLE
from resuming import whole_and_in_parts

from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs import run as design
from hfc_design.simulation import compiled
from hfc_design.simulation.evaluating import evaluate

SMALL = ["simulation.duration_s=4.0", "search.population=16", "search.generations=5"]


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A run of few tables, and how often its programs were compiled."""
    folder = tmp_path_factory.mktemp("runs") / "flc"
    scenario = load_scenario(CIRCLE, ["controller.kind=flc", *SMALL])
    programs = (compiled.scores_needed, compiled.trajectories)
    for program in programs:
        program.clear_cache()
    found = design.run(design.new_run(scenario, folder), folder)
    return found, [program._cache_size() for program in programs], folder


@pytest.fixture(scope="module")
def adaptive(tmp_path_factory):
    """The designs of short searches on the contour."""
    small = ["controller.kind=aflc", "search.population=64", "search.generations=15"]
    found = []
    for seed in range(3):
        folder = tmp_path_factory.mktemp("runs") / "aflc"
        scenario = load_scenario("feed-drive-contour", [*small, f"run.seed={seed}"])
        found.append(design.run(design.new_run(scenario, folder), folder).design)
    return found


UNSEEN = {
    "circle": "{kind='circle', radius_mm=25.0, feed_mm_min=500.0}",
    "circle, other way": "{kind='circle', radius_mm=15.0, feed_mm_min=300.0, direction='cw'}",
    "line": "{kind='line', length_mm=100.0, angle_deg=26.6, feed_mm_min=600.0}",
    "line to and fro": "{kind='polyline', points_mm=[[0.0, 0.0], [60.0, -40.0], [0.0, 0.0]], "
    "feed_mm_min=600.0}",
}


@pytest.mark.parametrize("name", UNSEEN)
def test_designed_table_beats_table_3_where_it_was_not_searched(adaptive, name):
    """From the first 10 s on, which are less than a cycle; both adapt."""
    short = "simulation.duration_s=10.0"
    scenario = load_scenario("feed-drive-contour", [f"reference={UNSEEN[name]}", short])
    published = evaluate(load_design("jee-koren-2004-aflc"), scenario).metrics
    for found in adaptive:
        own = evaluate(found, scenario).metrics
        assert own["rms_contour_error_BLU"] < 0.8 * published["rms_contour_error_BLU"]
        if name != "line":  # on which no axis reverses
            assert own["worst_glitch_BLU"] < 0.8 * published["worst_glitch_BLU"]


def test_stopped_and_resumed_equals_uninterrupted(tmp_path, no_baselines, known_use):
    whole_and_in_parts(load_scenario(CIRCLE, ["controller.kind=flc", *SMALL]), tmp_path, 3)
