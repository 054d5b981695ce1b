"""``hfc show``: what it tells, how it fits, that it starts no JAX."""

import json
import re

import numpy as np
import pytest
from places import ROOT
from run_folders import hfc
from wording import refused_command

from hfc_design.cli.showing import KINDS
from hfc_design.files.named_scenario import load_scenario
from hfc_design.reference.entries import in_units, things

DOCS = ROOT / "docs"


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_is_listed(kind):
    done = hfc("show", kind)
    assert done.exit_code == 0, done.output
    names = [line.split()[0] for line in done.stdout.splitlines() if line.strip()]
    assert {one.name for one in things(kind) if len(one.name) < 30} <= {*names} or kind == "key"


@pytest.mark.parametrize("width", [60, 80, 120])
@pytest.mark.parametrize(
    "asked",
    [
        ("plant", "c-axis"),
        ("plant", "five-axis"),
        ("controller", "pd+hierarchical-fuzzy"),
        ("strategy", "race"),
        ("objective", "tolerances"),
        ("scenario", "c-axis-practical"),
        ("design", "lin-lee-1999-table-1"),
        ("key", "search"),
    ],
)
def test_it_fits(asked, width, monkeypatch):
    monkeypatch.setenv("COLUMNS", str(width))
    done = hfc("show", *asked)
    assert done.exit_code == 0, done.output
    assert max(map(len, done.stdout.splitlines())) <= width


@pytest.mark.parametrize("width", [60, 80])
def test_no_word_of_a_key_is_cut(width, monkeypatch):
    monkeypatch.setenv("COLUMNS", str(width))
    shown = hfc("show", "scenario", "c-axis-practical").stdout
    lines = [line.rstrip() for line in shown.splitlines()]
    folded = [k for k, line in enumerate(lines) if line.startswith("fitness.tolerances.rms_error.")]
    assert [lines[k].split()[0][-1] + lines[k + 1] for k in folded] == [".  tolerance", ".  weight"]


def test_a_plant_with_units_and_source(monkeypatch):
    monkeypatch.setenv("COLUMNS", "120")
    lines = [" ".join(line.split()) for line in hfc("show", "plant", "c-axis").stdout.splitlines()]
    assert "source: Lin & Lee 1999, eq. 1-2" in lines
    found = [line for line in lines if line.startswith("spindle_inertia")]
    assert found == ["spindle_inertia 5.102 kg m2 of spindle and workpiece, J_c; greater than 0"]


def test_a_scenario_says_what_it_sets_and_what_a_motion_has_from_it(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text(
        '[simulation]\nduration_s = 3.5\n[limits]\naxes.x.command = 4.0\n[[motions]]\nname = "a"\n'
    )
    found = json.loads(hfc("show", "scenario", str(file), "--json").stdout)
    keys = {one["key"]: one for one in found["keys"]}
    assert keys["simulation.duration_s"]["value"] == 3.5
    assert keys["simulation.duration_s"]["default"] == 10.0
    assert keys["simulation.duration_s"]["where"] == "the file"
    assert keys["simulation.sample_time_s"]["where"] == "default"
    assert keys["limits.axes.x.command"]["unit"] == "V"
    assert not any(key.startswith("robust.") for key in keys)  # nothing of it holds
    assert [(one["key"], one["value"], one["where"]) for one in found["motions"]["a"]] == [
        ("duration_s", 3.5, "the scenario")
    ]


@pytest.mark.parametrize("name", [one.name for one in things("scenario")])
def test_every_built_in_scenario_has_keys_that_the_reference_knows(name):
    assert hfc("show", "scenario", name, "--json").exit_code == 0


def test_mistyped_keys_are_all_told_at_once(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text("[simulaton]\nduration_s = 1\n[run]\nsed = 1\n")
    told = refused_command("show", "scenario", file)
    assert told.where == str(file)
    assert ": simulaton.duration_s: " in told
    assert " run.sed: " in told


def test_a_design_with_the_units_of_its_plant():
    found = json.loads(hfc("show", "design", "lin-lee-1999-table-1", "--json").stdout)
    keys = {one["key"]: one for one in found["keys"]}
    assert keys["pd.kp"]["value"] == 758.405  # Table I
    assert keys["pd.kp"]["unit"] == "V/rad"
    assert {"name": "deflection", "unit": "rad"}.items() <= found["signals"][2].items()
    assert [unit["id"] for unit in found["units"]] == [7, 3, 1, 0]


def test_what_a_controller_is_to_follow_has_a_unit_and_a_meaning():
    found = json.loads(hfc("show", "design", "emps-cascade", "--json").stdout)
    signals = {one.pop("name"): one for one in found["signals"]}
    rate = {"unit": "mm/s", "meaning": "velocity that is commanded"}
    assert signals["reference_rate"] == rate
    assert signals["reference_acceleration"]["unit"] == "mm/s2"
    assert all(one["unit"] and one["meaning"] for one in signals.values())
    (gain,) = (one for one in found["keys"] if one["key"] == "signals.velocity")
    assert (gain["unit"], gain["meaning"]) == (
        "V/(mm/s)",
        "gains on signals of the drive's sensors",
    )


def test_an_own_plant(own_plugins):
    done = hfc("show", "plant", "examples.02_own_plant:TABLE", "--json")
    assert done.exit_code == 0, done.output
    every = json.loads(done.stdout)
    assert every[0]["name"] != ""
    told = hfc("show", "plant", "examples.02_own_plant:TABLE").stdout
    assert "greater than 0" in told
    assert " ; more" not in told
    assert [one for one in every if one["part"] == "parameter"]


def test_an_own_objective_without_a_meaning_is_told_by_its_title(
    monkeypatch, tmp_path, own_plugins
):
    text = "from hfc_design.objectives.judge import OBJECTIVES\nHALF = OBJECTIVES.get('lin-lee')"
    told = "._replace(name='half', meaning='', title='half of it', unit='1/mm')"
    (tmp_path / "halves.py").write_text(text + told)
    monkeypatch.chdir(tmp_path)
    done = hfc("show", "objective", "halves:HALF")
    assert done.stdout.splitlines()[0].rstrip() == "objective half: half of it [1/mm]"


def test_a_scenario_of_an_own_plant_has_its_units(own_plugins):
    file = DOCS.parent / "examples" / "belt_table.toml"
    done = hfc("show", "scenario", file, "--use", "examples.02_own_plant:TABLE", "--json")
    keys = {one["key"]: one for one in json.loads(done.stdout)["keys"]}
    assert keys["reference.distance"]["unit"] == "m"


def test_units_of_a_plant_in_those_of_the_reference():
    units = {"error": "rad", "command": "V", "load": "N m"}
    assert in_units("command/(error s)", units) == "V/(rad s)"
    assert in_units("command/load", units) == "V/(N m)"
    assert in_units("load", units) == "N m"


def test_the_page_shows_what_the_commands_say(tmp_path, monkeypatch):
    blocks = re.findall(r"```text\n\$ hfc (.*?)\n(.*?)\n```", (DOCS / "show.md").read_text(), re.S)
    assert len(blocks) == 4
    (tmp_path / "mine.toml").write_text("simulaton.duration_s = 1\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    for command, shown in blocks:
        lines = [line.rstrip() for line in hfc(*command.split()).output.splitlines()]
        assert "\n".join(lines).startswith(shown), command


def test_parameters_of_an_axis_of_two_of_one_drive(tmp_path):
    found = json.loads(hfc("show", "scenario", "feed-drive-circle", "--json").stdout)
    (own,) = [one for one in found["keys"] if one["key"] == "plant.axes.y.positive_start"]
    assert (own["value"], own["default"], own["unit"]) == (7.23, 6.54, "unit")  # JK04 eq. 28
    file = tmp_path / "mine.toml"
    file.write_text("[plant.axes.x]\nspindle_inertai = 3.0\n")
    assert ": plant.axes.x.spindle_inertai: " in refused_command("show", "scenario", file)


def test_the_example_of_tables_can_be_run(tmp_path):
    file = DOCS.parent / "examples" / "from_tables.toml"
    scenario = load_scenario(str(file), {"search.generations": 2})
    time = scenario.simulation.time
    samples = scenario.samples().axes[0]
    assert samples.target[-1] == pytest.approx(40.0)  # where move.csv ends
    assert samples.target[np.searchsorted(time, 1.2)] == pytest.approx(20.0, abs=0.1)  # half way
    assert samples.loads[0][np.searchsorted(time, 1.2)] == pytest.approx(60.0)


def test_a_scenario_is_shown_only_with_numbers_where_they_belong(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(
        '[sensors]\nencoder_resolution = "1 mrad"\n[plant.parameters]\npoles = true\n'
        '[fitness]\nkind = "tolerances"\n[fitness.tolerances]\nmax_error = "20 urad"\n'
    )
    told = refused_command("show", "scenario", path)
    assert told.where == str(path)
    assert ": sensors.encoder_resolution = '1 mrad': " in told
    assert "; plant.parameters.poles = True: " in told


def test_the_other_number_of_a_kind_serves_too():
    for one, other in (("strategy", "strategies"), ("objective", "fitnesses"), ("key", "keys")):
        assert hfc("show", other).stdout == hfc("show", one).stdout != ""
    for one, other in (("designs", "design"), ("fitnesses", "objectives"), ("formats", "format")):
        assert hfc("list", other).stdout == hfc("list", one).stdout != ""


def test_a_table_of_keys_shows_those_of_all_plants_and_names_the_plants():
    shown = hfc("show", "key", "plant").stdout
    rows = [line.split()[0] for line in shown.splitlines() if line.startswith("plant")]
    assert rows == ["plant", "plant.name", "plant.parameters", "plant.axes"]
    told = " ".join(shown.split())
    plants = ", ".join(one.name for one in things("plant"))
    assert f"Each plant has its own keys here, as in hfc show plant c-axis: {plants}" in told
    assert "(race)" in hfc("show", "key", "search.population").stdout  # which is of kinds alone
    every = json.loads(hfc("show", "key", "plant", "--json").stdout)
    assert "plant.parameters.poles" in [one["key"] for one in every]


def test_metrics_as_tables_have_them():
    for asked in ("chatter", "max_error_mm", "stick_share"):
        assert hfc("show", "metric", asked).exit_code == 0
