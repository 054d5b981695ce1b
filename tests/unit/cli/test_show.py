"""``hfc show`` and ``hfc init``: what they tell, how it fits, that every key is explained."""

import json
import re

import numpy as np
import pytest
from click.testing import CliRunner
from places import ROOT
from run_folders import hfc
from wording import refused_command

from hfc_design.cli import main
from hfc_design.files.design import named_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.objectives.metrics import METRICS
from hfc_design.reference.entries import things
from plants import C_AXIS
from plants.milling_table import MILLING_TABLE
from plants.positioning_stage import POSITIONING_STAGE

DOCS = ROOT / "docs"


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


def test_an_own_plant(own_plugins):
    done = hfc("show", "plant", "examples.02_own_plant:TABLE", "--json")
    assert done.exit_code == 0, done.output
    every = json.loads(done.stdout)
    assert every[0]["name"] != ""
    told = hfc("show", "plant", "examples.02_own_plant:TABLE").stdout
    assert "greater than 0" in told
    assert " ; more" not in told
    assert [one for one in every if one["part"] == "parameter"]


def test_the_page_shows_what_the_commands_say(tmp_path, monkeypatch):
    blocks = re.findall(r"```text\n\$ hfc (.*?)\n(.*?)\n```", (DOCS / "show.md").read_text(), re.S)
    assert len(blocks) == 4
    (tmp_path / "mine.toml").write_text("simulaton.duration_s = 1\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    for command, shown in blocks:
        lines = [line.rstrip() for line in hfc(*command.split()).output.splitlines()]
        assert "\n".join(lines).startswith(shown), command


def test_the_example_of_tables_can_be_run(tmp_path):
    file = DOCS.parent / "examples" / "from_tables.toml"
    scenario = load_scenario(str(file), {"search.generations": 2})
    time = scenario.simulation.time
    samples = scenario.samples().axes[0]
    assert samples.target[-1] == pytest.approx(40.0)  # where move.csv ends
    assert samples.target[np.searchsorted(time, 1.2)] == pytest.approx(20.0, abs=0.1)  # half way
    assert samples.loads[0][np.searchsorted(time, 1.2)] == pytest.approx(60.0)


def test_all_defaults_at_once_change_nothing(tmp_path):
    """Every commented key that holds by default is what it says."""
    file = tmp_path / "mine.toml"
    hfc("init", "--out", file)
    before = load_scenario(str(file)).model_dump(exclude={"plant"})
    text, *windows = file.read_text().partition("#[[windows]]")
    for table in ("plant", "simulation", "limits", "sensors", "search", "run"):
        head, found, rest = text.partition(f"\n[{table}]\n")
        own, mark, after = rest.partition("\n\n")
        own = re.sub(r"^#(\w+ = (?!NUMBER|\"TEXT|\.\.\.))", r"\1", own, flags=re.MULTILINE)
        text = head + found + own + mark + after
    file.write_text("".join([text, *windows]))
    assert text.count("\nsubsteps = 1") == 1
    assert load_scenario(str(file)).model_dump(exclude={"plant"}) == before


def test_the_start_of_a_motion_that_is_no_longer_commented_is_a_table_of_it(tmp_path):
    file = tmp_path / "mine.toml"
    hfc("init", "--out", file)
    text = file.read_text().replace("#[[motions]]", '[[motions]]\nname = "off"')
    file.write_text(text.replace("#[motions.start]", "[motions.start]\nspindle_angle = 0.01"))
    assert load_scenario(str(file)).motions[0].start == {"spindle_angle": 0.01}


@pytest.mark.parametrize("kind", ["pid", "pid+ff", "lqr"])
def test_other_controllers(kind, tmp_path):
    file = tmp_path / "mine.toml"
    done = hfc("init", "--plant", "positioning-stage", "--controller", kind, "--out", file)
    assert done.exit_code == 0, done.output
    assert load_scenario(str(file)).controller.kind == kind


@pytest.mark.parametrize("drive", [C_AXIS, MILLING_TABLE, POSITIONING_STAGE])
def test_every_parameter_has_a_unit(drive):
    assert [*drive.parameter_units] == [*drive.parameters._fields]


@pytest.mark.parametrize("command", main.commands)
def test_help_fits_into_80_columns(command):
    """Of an option with many choices the first column is as long as they are."""
    told = CliRunner().invoke(main, [command, "-h"], env={"COLUMNS": "80"}).stdout
    assert max(map(len, told.splitlines())) <= 80
    assert not re.search(r"\w\.\.\.$", told, re.MULTILINE)


def test_a_misspelt_metric_is_unknown_and_a_margin_is_no_target(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text(
        'fitness.kind = "tolerances"\n'
        "[constraints]\nrms_eror = 1\nsensitivity = 2\nband = 3\nsettling_time = 1\n"
        "[fitness.tolerances]\ngain_margin = 2\nrms_contour_error = 1\n"
        "chater = { tolerance = 1, weight = 3 }\n"
    )
    line = refused_command("show", "scenario", file)
    found = re.findall(r"([\w.]+): unknown metric", line)
    assert found == [
        "fitness.tolerances.gain_margin",
        "fitness.tolerances.chater.tolerance",
        "constraints.rms_eror",
        "constraints.settling_time",
    ]


def test_every_metric_of_a_table_has_a_meaning():
    """By the names of the columns themselves, of an axis, a path and a program."""
    known = {one.name for one in things("metric")}
    assert {one.name for one in METRICS} <= known
    done = hfc("show", "metric", "settling_time")
    assert "below a tenth of its maximum [s]; in tables only" in " ".join(done.stdout.split())


@pytest.mark.parametrize("name", [one.name for one in things("design")])
def test_the_list_of_designs_names_kind_and_plant(name):
    design = named_design(name)
    meaning = next(one.meaning for one in things("design") if one.name == name)
    assert meaning.startswith(f"{design.controller.kind} for {design.plant.name}: ")
