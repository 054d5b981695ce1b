"""A log that SciPy made of a plant of one's own, identified by a script as by the command."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from moved_masses import FORCE, moved, write
from sledge import MODULE

import hfc_design.api as hfc
from hfc_design.cli import main

TRUE = {"mass": 5.0, "friction": 9.0}


@pytest.fixture(autouse=True)
def log(own_plugins, tmp_path, monkeypatch):
    """A mass of 5 kg against 9 N s/m, measured with 2 um of noise."""
    monkeypatch.chdir(tmp_path)
    sys.path.insert(0, str(tmp_path))
    (tmp_path / "mine.py").write_text(MODULE)
    write("log.csv", "time_s,place_m,command_N", moved(*TRUE.values()), FORCE)


def test_a_script_finds_what_the_command_finds():
    said = []
    found = hfc.identify("log.csv", "mine:SLEDGE", folder="found", on_step=said.append)
    assert len(said) > 3
    numbers = found.numbers()
    for name, true in TRUE.items():
        own = numbers["parameters"][name]
        assert own["low"] < true < own["high"]
        assert own["value"] == pytest.approx(true, rel=0.01)
        assert f"{name}=" in repr(found)
        assert name in found._repr_html_()
    assert numbers == json.loads(Path("found", "identified.json").read_text())
    scenario = found.for_design()
    assert scenario == hfc.load_scenario("found/scenario.toml").model_copy(
        update={"name": scenario.name}
    )
    assert scenario.plant.parameters["mass"] == pytest.approx(TRUE["mass"], rel=0.01)
    assert scenario.robust.tolerances.keys() == TRUE.keys()
    (axes, *_) = hfc.plot(found).axes
    assert axes.get_ylabel() == "position [m]"
    words = ["identify", "log.csv", "--plant", "mine:SLEDGE", "--json", "--out", "again"]
    done = CliRunner().invoke(main, words)
    assert json.loads(done.stdout) == numbers


def test_a_command_that_acts_later_is_told_in_seconds():
    """The place is that of three samples of 1 ms ago."""
    time, place, force = np.loadtxt("log.csv", delimiter=",", skiprows=1).T
    rows = np.stack([time, np.r_[[place[0]] * 3, place[:-3]], force], axis=1)
    np.savetxt("late.csv", rows, "%.12g", ",", header="time_s,place_m,command_N", comments="")
    late = hfc.identify("late.csv", "mine:SLEDGE").numbers()["command_late_s"]
    assert late["value"] == pytest.approx(3e-3, abs=1e-4)
    assert late["low"] < 3e-3 < late["high"]
