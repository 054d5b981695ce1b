"""What cannot be polished."""

import pytest
from wording import refused

from hfc_design.controllers.gains.genome import GainsGenome
from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs import polishing, run


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
