"""Controllers whose gains are a few numbers, by search: pd and pid."""

import json
import math

import numpy as np
import pytest
from click.testing import CliRunner

from hfc_design import api
from hfc_design.cli import main
from hfc_design.controllers.gains.genome import GainsGenome, GainVectors
from hfc_design.controllers.kinds import KINDS
from hfc_design.search.loop import generations, searcher
from hfc_design.search.strategies.race import RaceSettings
from hfc_design.search.strategy import Task
from plants import FEED_DRIVE

RANGES = {"k_p": (0.1, 1000.0), "k_i": (0.0, 8.0), "k_d": (-1.0, 3.0)}
GENOME = GainsGenome(
    KINDS.get("pid").settings(kind="pid", ranges=RANGES),
    api.load_scenario("feed-drive-line").target,
)


def individuals(*places):
    return GainVectors(np.zeros(len(places), int), np.array(places, float))


def test_places_of_gains_in_their_ranges():
    """0.1 to 1000 are four decades; the other two ranges reach to zero or below it."""
    found = GENOME.gains(individuals([0.0, 0.0, 0.0], [0.25, 0.25, 0.25], [1.0, 1.0, 1.0]))
    np.testing.assert_allclose(found.k_p, [0.1, 1.0, 1000.0])
    np.testing.assert_allclose(found.k_i, [0.0, 2.0, 8.0])
    np.testing.assert_allclose(found.k_d, [-1.0, 0.0, 3.0])
    record = GENOME.record(individuals([0.5, 0.5, 0.5]))
    assert record == {"kind": "pid", "pid": pytest.approx({"k_p": 10.0, "k_i": 4.0, "k_d": 1.0})}


def test_nothing_leaves_the_ranges():
    rng = np.random.default_rng(1)
    found = GENOME.fresh(np.zeros(500, int), rng)
    for _ in range(5):
        mutated = GENOME.mutated(found, np.full(500, 1.0), rng)
        share = rng.uniform(-0.25, 1.25, 500)
        found = GENOME.nudged(GENOME.blended(mutated, found, share), rng)
        assert found.places.min() >= 0.0
        assert found.places.max() <= 1.0
    assert len(np.unique(found.places)) > 1000


@pytest.mark.parametrize("seed", range(4))
def test_the_race_finds_the_best_gains(seed):
    """Of a score that has its best at k_p = 30, k_i = 6, k_d = -0.5."""

    def score(population, generation, needed=None):
        gains = GENOME.gains(population)
        off = np.log(gains.k_p / 30.0) ** 2 + (gains.k_i - 6.0) ** 2 + (gains.k_d + 0.5) ** 2
        return 1.0 / (1.0 + off)

    settings = RaceSettings(population=32, generations=150)
    race = searcher(settings, Task(GENOME))
    *_, search = generations(race, GENOME, 150, seed, score)
    found = GENOME.gains(search.archive.population)
    assert found.k_p[0] == pytest.approx(30.0, rel=1e-3)
    assert found.k_i[0] == pytest.approx(6.0, abs=1e-3)
    assert found.k_d[0] == pytest.approx(-0.5, abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "kind", "seconds"), [("c-axis-ramp", "pd", 0.5), ("feed-drive-line", "pid", 1.0)]
)
def test_design_of_gains_ends_with_a_report_and_resumes(
    name, kind, seconds, tmp_path, no_baselines
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
    whole = api.design(scenario, tmp_path / "whole")

    class Stopped(Exception):
        pass

    def stop(search):
        if search.generation == 2:
            raise Stopped

    with pytest.raises(Stopped):
        api.design(scenario, tmp_path / "parts", stop)
    again = api.design(scenario, tmp_path / "parts")
    assert again.design == whole.design == api.design(scenario).design
    for file in ("design.json", "history.csv", "report.html"):
        assert (tmp_path / "parts" / file).read_bytes() == (tmp_path / "whole" / file).read_bytes()
    assert not (tmp_path / "whole" / "tables").exists()
    page = (tmp_path / "whole" / "report.html").read_text()
    assert f"Gains of the kind {kind}" in page
    gains = getattr(whole.design.controller, kind).model_dump()
    assert all(f"{value:.6g}" in page for value in gains.values())
    with pytest.raises(api.UserError, match="another scenario"):
        api.design(scenario.model_copy(update={"description": "other"}), tmp_path / "parts")


@pytest.mark.slow
def test_a_run_with_a_file_of_its_own_goes_on_too(tmp_path):
    """The run folder holds a copy of the table, under another path."""
    table = tmp_path / "way.csv"
    table.write_text("time_s,reference\n0,0\n1,0.01\n")
    scenario = api.load_scenario(
        {
            "reference": {"kind": "csv", "file": str(table)},
            "controller": {"kind": "pd"},
            "search": {"population": 4, "generations": 2},
            "simulation": {"duration_s": 0.2},
        }
    )
    assert (
        api.design(scenario, tmp_path / "run").design
        == api.design(scenario, tmp_path / "run").design
    )


@pytest.mark.slow
def test_pid_by_search_is_no_worse_than_by_pole_placement():
    """The published gains 1.5, 8.1, 0.1 lie in the ranges; whatever the seed."""
    changes = {"controller": {"kind": "pid"}, "search.population": 32, "search.generations": 8}
    for seed in range(4):
        scenario = api.load_scenario("feed-drive-line", changes | {"run.seed": seed})
        published = api.evaluate(api.load_design("jee-koren-2004-pid"), scenario)
        assert api.design(scenario).evaluation.fitness > published.fitness


def test_design_by_hand_is_the_published_one():
    scenario = api.load_scenario("feed-drive-circle", {"simulation.duration_s": 5.0})
    by_hand = api.with_gains(scenario, "pid", {"k_p": 1.5, "k_i": 8.1, "k_d": 0.1})
    published = api.load_design("jee-koren-2004-pid")
    assert by_hand.controller == published.controller
    assert math.isclose(
        api.evaluate(by_hand, scenario).fitness, api.evaluate(published, scenario).fitness
    )


def test_command_line_searches_pd(tmp_path, no_baselines):
    run = tmp_path / "run"
    options = ["--controller", "pd", "--population", "8", "--generations", "2", "--quiet"]
    arguments = ["design", "c-axis-ramp", *options, "--out", str(run)]
    done = CliRunner().invoke(main, [*arguments, "--set", "simulation.duration_s=0.5"])
    assert done.exit_code == 0, done.output
    assert json.loads((run / "design.json").read_text())["controller"]["kind"] == "pd"


NO_RANGE = "no range; those that 'pd' has are for c-axis, not for"


@pytest.mark.parametrize(
    ("plant", "kind", "told"),
    [
        (
            "milling-table",
            "pd",
            rf"controller.ranges: kp, kd: {NO_RANGE} milling-table \(errors in",
        ),
        (
            "c-axis",
            "pid",
            r"k_p, k_i, k_d: no range; .* not for c-axis \(errors in rad, commands in",
        ),
    ],
)
def test_ranges_are_for_plants_of_their_units(plant, kind, told):
    scenario = {"plant": {"name": plant}, "controller": {"kind": kind}}
    with pytest.raises(api.UserError, match=told):
        api.load_scenario(scenario)
    own = {key: [1.0, 2.0] for key in KINDS.get(kind).settings.own_ranges._fields}
    part = dict(list(own.items())[1:])
    with pytest.raises(api.UserError, match=f"controller.ranges: {next(iter(own))}: no range"):
        api.load_scenario(scenario | {"controller": {"kind": kind, "ranges": part}})
    found = api.load_scenario(scenario | {"controller": {"kind": kind, "ranges": own}})
    assert set(found.controller.searched()) == {(1.0, 2.0)}


CIRCLE = {"reference": {"kind": "circle", "radius_mm": 5.0, "feed_mm_min": 600.0}}


def test_an_own_plant_needs_ranges_inside_too():
    """A machine of one's own, of drives that the package has."""
    api.register(api.side_by_side("own-table", x=FEED_DRIVE, y=FEED_DRIVE))
    each = {"kind": "per-axis", "axes": {axis: {"kind": "pid"} for axis in "xy"}}
    with pytest.raises(api.UserError, match=r"controller.axes.x.ranges: k_p, k_i, k_d: no range"):
        api.load_scenario({"plant": {"name": "own-table"}, "controller": each, **CIRCLE})
