"""A batch of a script: what its folder holds, and what fails."""

import csv

import pytest
from batches import written
from wording import refused

import hfc_design.api as hfc

GRID = """
[set]
simulation.duration_s = 0.05
search.population = 4
search.generations = 2
controller.kind = "pd"
[grid]
run.seed = [0, 1, 2]
"""


def test_cells_are_run_and_summed_up(tmp_path):
    done = []
    found = hfc.batch(
        written(tmp_path, GRID),
        tmp_path / "out",
        {"search.generations": 1},
        on_cell=lambda cell, outcome: done.append((cell.settings["run.seed"], outcome.state)),
    )
    assert sorted(done) == [(seed, "finished") for seed in range(3)]
    assert [len(run.best) for run in found.runs] == [1, 1, 1]
    (group,) = found.groups
    with open(tmp_path / "out" / "runs.csv", newline="") as file:
        merits = [float(row["merit"]) for row in csv.DictReader(file)]
    assert group.median == pytest.approx(sorted(merits)[1])
    assert repr(found).startswith("Findings(runs=3, groups=1")
    assert repr(hfc.findings(tmp_path / "out")) == repr(found)


def test_a_cell_that_fails_is_an_error_after_the_others(tmp_path):
    path, out = written(tmp_path, GRID), tmp_path / "out"
    hfc.batch(path, out)
    (victim, *_) = [one for one in out.iterdir() if (one / "design.json").exists()]
    for file in victim.iterdir():
        file.unlink()
    (victim / "config.toml").mkdir()  # nobody can write that file
    with pytest.raises(hfc.RunError, match=rf"1 of 3 cells failed: {victim.name}"):
        hfc.batch(path, out)
    states = sorted(run.state for run in hfc.findings(out).runs)
    assert states == ["failed", "finished", "finished"]
    with refused():
        hfc.findings(tmp_path / "nowhere")
