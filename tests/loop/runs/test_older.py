"""Run folders that an earlier version left broken off: what had failed scored 0 in them."""

import json
import shutil

import numpy as np
import pytest
from places import DATA
from wording import refused

from hfc_design.core.records import RunError
from hfc_design.runs import run, stored

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
