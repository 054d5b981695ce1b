"""Run folders: what is in them, and that no interruption changes or loses anything."""

import json
import os
import shutil

import jax
import numpy as np
import pytest
import tomli_w
from places import DATA
from short_runs import SEARCHES, contents, once, resumed, started, stopping
from wording import refused

from hfc_design.controllers.gains.genome import GainsGenome
from hfc_design.core.records import RunError
from hfc_design.files.loop_setup import load_design, own_scenario
from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs import polishing, run, stored
from hfc_design.runs import run as design
from hfc_design.simulation.evaluating import evaluate


@pytest.fixture(scope="module")
def wholes(tmp_path_factory):
    return once(tmp_path_factory.mktemp("runs"))


@pytest.fixture
def whole(wholes):
    """The folder of a race that nobody interrupted."""
    return wholes()[0]


@pytest.mark.parametrize("name", SEARCHES)
def test_interrupted_and_resumed_equals_uninterrupted(wholes, tmp_path, name):
    folder, _ = wholes(*SEARCHES[name])
    part = tmp_path / "part"
    stopping(started(part, SEARCHES[name]), part, 2)
    resumed(part)
    assert contents(part) == contents(folder)
    files = {"config.toml", "checkpoint.npz", "history.csv", "design.json"}
    assert set(contents(folder)) == files | ({"front.csv"} if name == "nsga-ii" else set())
    rows = np.genfromtxt(folder / "history.csv", delimiter=",", names=True)
    assert rows["generation"].tolist() == list(range(5))
    assert (np.diff(rows["best"]) >= 0).all()


def test_damaged_checkpoints_are_refused_and_left_alone(whole, tmp_path):
    part = tmp_path / "part"
    part.mkdir()
    (part / "config.toml").write_bytes((whole / "config.toml").read_bytes())
    good = (whole / "checkpoint.npz").read_bytes()
    middle = len(good) // 2
    flipped = good[:middle] + bytes([good[middle] ^ 0xFF]) + good[middle + 1 :]
    for bad in (good[:middle], good[:-1], flipped, b"", b"not a checkpoint", good[4:]):
        (part / "checkpoint.npz").write_bytes(bad)
        with pytest.raises(RunError, match=r"checkpoint\.npz: is damaged"):
            resumed(part)
        assert (part / "checkpoint.npz").read_bytes() == bad


def test_checkpoint_of_another_run_is_refused(whole, tmp_path):
    part = tmp_path / "part"
    scenario = started(part, ["run.seed=5"])
    foreign = (whole / "checkpoint.npz").read_bytes()
    (part / "checkpoint.npz").write_bytes(foreign)
    with pytest.raises(RunError, match=r"checkpoint\.npz: .* another config\.toml"):
        design.run(scenario, part)
    assert (part / "checkpoint.npz").read_bytes() == foreign


def test_pickled_arrays_are_refused(whole, tmp_path):
    with np.load(whole / "checkpoint.npz") as arrays:
        data = dict(arrays)
    data["generation"] = np.array([{"a": 1}], dtype=object)
    np.savez(tmp_path / "bad.npz", **data)
    with pytest.raises(RunError, match="is damaged"):
        stored.load(tmp_path / "bad.npz", design.opened_run(whole), {})


def test_folder_that_holds_a_run_is_refused(whole):
    before = contents(whole)
    with refused() as found:
        started(whole)
    assert found.where == f"folder='{whole}'"
    assert contents(whole) == before


def test_disk_that_fills_during_a_run_leaves_a_resumable_run(whole, tmp_path, monkeypatch):
    part = tmp_path / "part"
    scenario = started(part)
    monkeypatch.setattr(stored, "CHECKPOINT_EVERY", 0.0)
    real, calls = os.fsync, []

    def full_after_a_while(descriptor):
        calls.append(descriptor)
        if len(calls) > 6:
            raise OSError(28, "No space left on device")
        real(descriptor)

    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", full_after_a_while)
        with refused(RunError):
            design.run(scenario, part)
    resumed(part)
    assert contents(part) == contents(whole)


def test_design_scores_what_it_says_on_the_scenario_it_carries(whole):
    found = load_design(str(whole))
    scenario = own_scenario(found, str(whole))
    assert scenario == design.opened_run(whole)
    assert evaluate(found, scenario).fitness == found.score["fitness"]


def test_config_alone_runs_the_same_again(whole, tmp_path):
    scenario = load_scenario(str(whole / "config.toml"))
    design.run(design.new_run(scenario, tmp_path / "again"), tmp_path / "again")
    assert contents(tmp_path / "again") == contents(whole)


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


#: A race of five PD controllers after its first generation, in which four diverged.
BROKEN_OFF = DATA / "broken_off_1"


def test_a_run_that_an_earlier_version_began_goes_on(tmp_path):
    folder = tmp_path / "run"
    shutil.copytree(BROKEN_OFF, folder)
    with refused(RunError) as found:
        run.run(run.opened_run(folder), folder)
    assert found.where == str(folder / "checkpoint.npz")
    assert sorted(path.name for path in folder.iterdir()) == ["checkpoint.npz", "config.toml"]
    run.run(run.opened_run(folder), folder, anyway=True)
    rows = np.genfromtxt(folder / "history.csv", delimiter=",", names=True)
    # What that version made of its generations; later ones see fast spindles that it took for nan.
    assert rows["best"][:2] == pytest.approx([74.610207, 163.092758], rel=1e-4)
    assert len(rows) == 8
    assert (np.diff(rows["best"]) >= 0).all()
    assert rows["diverged"][0] == 4
    assert rows["median"][0] == 0.0  # as it was told then
    assert rows["median"][1:].min() > 0.0
    design = json.loads((folder / "design.json").read_text())
    assert design["score"]["merit"] == pytest.approx(rows["best"][-1], rel=1e-4)


def test_what_had_failed_ranks_last(tmp_path):
    scenario = run.opened_run(BROKEN_OFF)
    state = stored.load(BROKEN_OFF / run.CHECKPOINT, scenario, {}).state
    assert np.isneginf(state.score).tolist() == [False, True, True, True, True]
    assert state.score[0] == pytest.approx(74.610207, rel=1e-6)


def test_a_kind_without_coordinates_is_refused_before_anything_is_written(tmp_path, monkeypatch):
    """One axis of a user's own without ``around`` is enough."""
    axes = {axis: {"kind": "pid"} for axis in "xy"}
    changes = {"controller": {"kind": "per-axis", "axes": axes}, "run.polish": 3}
    scenario = load_scenario("feed-drive-circle", changes)
    polishing.check_polish(scenario)
    monkeypatch.setattr(GainsGenome, "around", lambda genome, about: None)
    with refused() as found:
        run.new_run(scenario, tmp_path / "run")
    assert found.where == "run.polish"
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("changes", [["run.polish=-1"], ["run.polish=3", "search.preset=nsga-ii"]])
def test_what_cannot_be_polished_is_refused_in_a_line(changes):
    with refused() as found:
        load_scenario("c-axis-ramp", changes)
    assert "run.polish = " in found.refusal
