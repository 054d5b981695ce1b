"""Run folders: what is in them, and that no interruption changes or loses anything."""

import jax
import numpy as np
import pytest
import tomli_w

from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.pairing import load_design, own_scenario
from hfc_design.runs import run as design
from hfc_design.simulation.evaluating import evaluate

#: As short as the batches of other tests, so that all have the same compiled programs.
SMALL = ["simulation.duration_s=0.1", "search.population=24", "search.generations=9"]
SEARCHES = [[], ["search.preset=lin-lee-1999"]]


def started(folder, changes=()):
    return design.new_run(load_scenario("c-axis-ramp", [*SMALL, *changes]), folder)


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


@pytest.fixture(scope="module", params=SEARCHES, ids=["race", "lin-lee"])
def whole(request, tmp_path_factory):
    """An uninterrupted run: its folder and what was changed in its scenario."""
    folder = tmp_path_factory.mktemp("runs") / "whole"
    design.run(started(folder, request.param), folder)
    return folder, request.param


def test_design_scores_what_it_says_on_the_scenario_it_carries(whole):
    folder, _ = whole
    found = load_design(str(folder))
    scenario = own_scenario(found, str(folder))
    assert scenario == design.opened_run(folder)
    assert evaluate(found, scenario).fitness == found.score["fitness"]


def test_config_alone_runs_the_same_again(whole, tmp_path):
    folder, _ = whole
    scenario = load_scenario(str(folder / "config.toml"))
    design.run(design.new_run(scenario, tmp_path / "again"), tmp_path / "again")
    assert contents(tmp_path / "again") == contents(folder)


def test_csv_tables_travel_with_the_run(tmp_path):
    (tmp_path / "way.csv").write_text("time_s,reference_rad\n0,0\n0.05,0.001\n0.1,0.0015\n")
    (tmp_path / "cut.csv").write_text("time_s,load_Nm\n0,0\n0.05,1\n")
    (tmp_path / "mine.toml").write_text(
        'reference = {kind = "csv", file = "way.csv"}\nload = {file = "cut.csv"}\n'
    )
    folder = tmp_path / "run"
    scenario = load_scenario(str(tmp_path / "mine.toml"), SMALL)
    result = design.run(design.new_run(scenario, folder), folder)
    (tmp_path / "way.csv").unlink()
    (tmp_path / "cut.csv").unlink()
    moved = tmp_path / "moved"
    folder.rename(moved)
    found = load_design(str(moved))
    again = evaluate(found, own_scenario(found, str(moved)))
    assert again.fitness == result.evaluation.fitness
    assert again.axes[0].reference[50] == pytest.approx(0.001)
    assert again.axes[0].load[25] == pytest.approx(0.5)


def test_tables_of_motions_and_of_axes_travel_too(tmp_path):
    tables = {"slow": 0.002, "fast": 0.01, "x": 50.0, "y": 20.0, "cut": 1.0}
    for name, end in tables.items():
        (tmp_path / f"{name}.csv").write_text(f"0,0\n0.1,{end}\n")
    several = {
        "motions": [
            {"name": "slow", "reference": {"kind": "csv", "file": "slow.csv"}},
            {"name": "fast", "load": {"file": "cut.csv"}},
        ],
        "reference": {"kind": "csv", "file": "fast.csv"},
    }
    axes = {axis: {"kind": "csv", "file": f"{axis}.csv"} for axis in "xy"}
    each = {
        "plant": {"name": "feed-drive", "axes": {"x": {}, "y": {}}},
        "reference": {"kind": "per-axis", "axes": axes},
        "load": {"axes": {"y": {"file": "cut.csv"}}},
        "simulation": {"sample_time_s": 0.01},
        "controller": {"kind": "pid"},
    }
    kept = {}
    for name, own in {"several": several, "each": each}.items():
        path = tmp_path / f"{name}.toml"
        path.write_text(tomli_w.dumps(own))
        scenario = load_scenario(str(path), ["simulation.duration_s=0.1"])
        kept[name] = [alone.samples().axes for alone in scenario.each_motion()]
        design.new_run(scenario, tmp_path / name)
    for name in tables:
        (tmp_path / f"{name}.csv").unlink()
    for name, before in kept.items():
        folder = (tmp_path / name).rename(tmp_path / f"{name}-moved")
        again = [alone.samples().axes for alone in design.opened_run(folder).each_motion()]
        jax.tree.map(np.testing.assert_array_equal, again, before)
    assert len(list(tmp_path.rglob("*.csv"))) == 6
