"""``hfc identify`` as a user calls it, on logs that SciPy made of plants without secrets."""

import html
import json
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner
from moved_masses import FORCE, moved, write
from sledge import MODULE

from hfc_design.cli import main
from hfc_design.files.named_scenario import load_scenario


def identify(*arguments):
    found = CliRunner().invoke(main, ["identify", *map(str, arguments)])
    assert found.exit_code == 0, found.output
    return found.stdout


@pytest.fixture(autouse=True)
def folder(own_plugins, tmp_path, monkeypatch):
    """A folder with a module of one's own; the plant SLEDGE has a mass of 2, a friction of 3."""
    monkeypatch.chdir(tmp_path)
    sys.path.insert(0, str(tmp_path))
    (tmp_path / "mine.py").write_text(MODULE)


def test_a_plant_of_ones_own_by_a_log_of_hostile_names():
    """Found within its intervals; nothing of the names gets into the page as it is."""
    name, column = "<script>alert(1)</script>".replace("/", "_") + ".csv", "<b>&\"'"
    write(name, 'time_s,"<b>&""\'",command_N', moved(5.0, 9.0), FORCE)
    write("other.csv", 'time_s,"<b>&""\'",command_N', moved(15.0, 9.0, seed=1), FORCE)
    told = identify(
        name, "--plant", "mine:SLEDGE", "--column", f"place={column}", "--out", "found",
        "--check-log", "other.csv",
    )  # fmt: skip
    assert "DOUBTFUL: other.csv is replayed" in told
    found = json.loads(Path("found", "identified.json").read_text())
    for parameter, true in {"mass": 5.0, "friction": 9.0}.items():
        own = found["parameters"][parameter]
        assert own["told"] == "yes"
        assert own["low"] < true < own["high"]
        assert own["value"] == pytest.approx(true, rel=0.01)
    page = Path("found", "report.html").read_text()
    assert "<script>alert" not in page
    assert "&lt;script&gt;alert" in page
    assert column not in page
    verdict, picture, table = map(
        page.index, ("The log determines 3 of 3 parameters", "<img", "<table")
    )
    assert page.index("DOUBTFUL") < verdict < picture < table
    assert "hfc design scenario.toml --use mine:SLEDGE" in page
    scenario = load_scenario("found/scenario.toml")
    assert scenario.plant.parameters["mass"] == pytest.approx(5.0, rel=0.01)


def test_millimetres_taken_for_metres_are_doubted_and_missing_friction_is_at_its_bound():
    """A stage without Coulomb friction, which begins with 20 N; then the log in other units."""
    volts = FORCE / 35.1507
    place = 1e3 * moved(95.11, 200.0, 5.0 * FORCE)  # [mm]
    write("stage.csv", "time_s,position_mm,voltage_V", place, 5.0 * volts)
    free = ("--plant", "positioning-stage", "--free", "mass,viscous_friction,coulomb_friction")
    steady = ("--set", "plant.parameters.offset=0")
    told = identify("stage.csv", *free, *steady, "--json", "--out", "one")
    own = json.loads(told)["parameters"]
    assert own["mass"]["low"] < 95.11 < own["mass"]["high"]
    assert own["viscous_friction"]["low"] < 200.0 < own["viscous_friction"]["high"]
    friction = own["coulomb_friction"]
    assert (friction["value"], friction["told"]) == (0.0, "at its bound")
    assert friction["low"] is friction["high"] is None
    assert load_scenario("one/scenario.toml").plant.parameters["coulomb_friction"] == 0.0
    told = identify(
        "stage.csv", *free, *steady, "--column", "position=position_mm [m]", "--out", "two"
    )
    assert "DOUBTFUL: stage.csv needs 0.001 times the start value of mass" in told


def test_a_move_one_way_tells_what_it_can_beside_what_is_held():
    """It does not part Coulomb friction from the offset, nor the gain from both: two are held."""
    command = ["simulate", "emps-cascade", "--set", "plant.parameters.mass=37", "--csv", "log.csv"]
    assert CliRunner().invoke(main, command).exit_code == 0
    told = identify("log.csv", "--plant", "positioning-stage", "--out", "stage")
    rows = {line.split()[0]: line.split() for line in told.partition("from and")[0].splitlines()}
    assert rows["mass"][3:] == ["37", "37", "37", "given"]
    assert [row[-1] for row in rows.values()].count("held") == 2
    assert rows["coulomb_friction"][-3:] == ["-", "-", "held"]
    line = "where 'given', if the fixed parameters (coulomb_friction, amplifier_gain) are correct"
    told = " ".join(told.split())
    page = html.unescape(Path("stage", "report.html").read_text())
    assert line in told
    assert line in page
    assert "responds the same to a command" in told
    assert "record next: the motion that hfc experiment scenario.toml makes" in told
    assert "the motion that hfc experiment scenario.toml makes" in page
    assert "the curve of a parameter given relative to a fixed one is wider" in " ".join(
        page.split()
    )
    own = json.loads(Path("stage", "identified.json").read_text())["parameters"]
    nominal = {"mass": 37.0, "viscous_friction": 203.5, "amplifier_gain": 35.1507}
    found = {name: own[name]["value"] for name in nominal}
    assert found == pytest.approx(nominal, rel=1e-6)
