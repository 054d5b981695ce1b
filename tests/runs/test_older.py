"""Run folders that an earlier version left broken off: what had failed scored 0 in them."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from hfc_design.core.records import RunError
from hfc_design.runs import run, stored

#: A race of five PD controllers after its first generation, in which four diverged.
BROKEN_OFF = Path(__file__).parent.parent / "data" / "broken_off_1"


def test_a_run_that_an_earlier_version_began_ends_as_it_would_have(tmp_path):
    folder = tmp_path / "run"
    shutil.copytree(BROKEN_OFF, folder)
    with pytest.raises(RunError, match=r"did not say what made it; with --anyway"):
        run.run(run.opened_run(folder), folder)
    assert sorted(path.name for path in folder.iterdir()) == ["checkpoint.npz", "config.toml"]
    run.run(run.opened_run(folder), folder, anyway=True)
    # What that version ended with, on the machine that it ran on.
    design = json.loads((folder / "design.json").read_text())
    gains = {"kp": 3488.40793571948, "kd": 2310.058453209248}
    assert design["controller"]["pd"] == pytest.approx(gains, rel=1e-4)
    assert design["score"]["fitness"] == pytest.approx(18436.608170590596, rel=1e-4)
    rows = np.genfromtxt(folder / "history.csv", delimiter=",", names=True)
    assert rows["best"][[0, 1, -1]] == pytest.approx([74.610207, 163.092758, 294.985962], rel=1e-4)
    assert rows["diverged"][:6].tolist() == [4, 3, 2, 1, 2, 2]
    assert rows["median"][0] == 0.0  # as it was told then
    assert rows["median"][1:].min() > 0.0


def test_what_had_failed_ranks_last(tmp_path):
    scenario = run.opened_run(BROKEN_OFF)
    state = stored.load(BROKEN_OFF / run.CHECKPOINT, scenario, {}).state
    assert np.isneginf(state.score).tolist() == [False, True, True, True, True]
    assert state.score[0] == pytest.approx(74.610207, rel=1e-6)
