"""``hfc init``: what it writes is searched as it is, of every plant."""

import pytest
from report_pages import unknown
from run_folders import hfc

from hfc_design.reference.entries import PLANT, things
from hfc_design.report import page


@pytest.mark.parametrize("plant", [one.name for one in things(PLANT)])
def test_it_can_be_searched_as_it_is(plant, tmp_path, monkeypatch, no_baselines):
    monkeypatch.setattr(page, "used", unknown)  # what it does on other machines, at length
    file, out = tmp_path / "mine.toml", tmp_path / "run"
    assert hfc("init", "--plant", plant, "--out", file).exit_code == 0
    few = ("--generations", 2, "--population", 6)
    done = hfc("design", file, *few, "--set", "simulation.duration_s=1.2", "--out", out, "--quiet")
    assert done.exit_code == 0, done.output
    assert (out / "design.json").is_file()
