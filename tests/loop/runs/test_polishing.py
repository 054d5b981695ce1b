"""A polished run: what it brings, that no interruption changes it, and what is refused."""

import pytest

from hfc_design.controllers.gains.genome import GainsGenome
from hfc_design.core.records import UserError
from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs import polishing, run


def test_a_kind_without_coordinates_is_refused_before_anything_is_written(tmp_path, monkeypatch):
    """One axis of a user's own without ``around`` is enough."""
    axes = {axis: {"kind": "pid"} for axis in "xy"}
    changes = {"controller": {"kind": "per-axis", "axes": axes}, "run.polish": 3}
    scenario = load_scenario("feed-drive-circle", changes)
    polishing.check_polish(scenario)
    monkeypatch.setattr(GainsGenome, "around", lambda genome, about: None)
    with pytest.raises(UserError, match=r"run\.polish = 3: .*'per-axis' cannot be polished"):
        run.new_run(scenario, tmp_path / "run")
    assert not (tmp_path / "run").exists()
