"""What a user gets wrong: one clear line, the right exit code, and nothing lost."""

import json
import re

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from plain_words import plain_lines
from wording import refused, refused_command

from hfc_design.core.overrides import overridden
from hfc_design.core.plugins import uses
from hfc_design.core.records import UserError
from hfc_design.files.design import design_json, parse_design
from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.scenario import Scenario

GOOD = design_json(load_design("lin-lee-1999-table-1"))


#: Changes of c-axis-ramp, the last of which is at fault.
CHANGES = [
    ["simulation.duration_s=0"],
    ["run.precision='float23'"],
    ["search.population='many'"],
    ["name='a b'"],
    ["reference={velocity=1}"],
    ["limits.axes.x.command=-1"],
    ["controller.kind=pidd"],
    ["plant.parameters.stator_inductance='4.7 mH'"],
    ["sensors.axes.x.noise='1 mrad'"],
    ["simulation.duration_s='2 s'"],
    ["fitness.tolerances={}"],
    ["robustness.spread=0.1"],
    ["constraints.max_eror=1"],
    ["run.precision=1"],
    ["search.preset=rase"],
    ["plant.parameters.spindle_mas=1"],
    ["plant.parameters.spindle_inertia=-1"],
    ["plant.parameters.mutual_inductance=9"],
    ["plant.name=d-axis"],
    ["search.population=0"],
    ["search.kp_range=[5,1]"],
    ["reference.kind=wiggle"],
    ["controller.inputs=[{name='error',scale=1.0},{name='mood',scale=1.0}]"],
    ["controller.inputs=[{name='error',scale=1.0}]"],
    ["limits.delay_samples=65"],
    ["simulation.duration_s=0.01", "limits.delay_samples=10"],
    ["robust.tolerances.stifness=0.1"],
    ["robust.tolerances.stiffness=1.5"],
    ["motions=[{name='a'},{name='b',simulation={substeps=2}}]"],
    ["motions=[{name='a'},{name='b',duration_s=2.0,settled_after_s=3.0}]"],
    ["robust.keep=best"],
    ["constraints.limit_share=nan"],
    ["constraints.late_error='1 kg'"],
    ["constraints.band_time=1"],
    ["fitness.kind=tolerances", "fitness.tolerances={fast=1}"],
    ["fitness.kind=tolerances", "fitness.tolerances={rms_error='1 kg'}"],
    ["fitness.kind=tolerances", "fitness.tolerances={rms_error=0}"],
    ["fitness.kind=tolerances", "fitness.tolerances={band_time=1}"],
]


@pytest.mark.parametrize("changes", CHANGES, ids=lambda changes: changes[-1])
def test_a_change_that_is_not_allowed_is_a_line_of_its_key(changes):
    with refused() as found:
        load_scenario("c-axis-ramp", changes)
    (line,) = plain_lines(found.error)
    *_, key = (change.partition("=")[0] for change in changes)
    told = re.split(": | = ", line)[1]  # of the table where its keys together are at fault
    assert told.startswith(key) or key.startswith(told)


#: Command line -> what its refusal begins with.
COMMANDS = {
    "design c-axis-ramp --population 0 --out run": "c-axis-ramp",
    "design c-axis-ramp --pareto tracking,fun --out run": "--pareto fun",
    "design c-axis-ramp --set name.first=x --out run": "--set name.first=x",
    "score no-such-design": "no-such-design",
    "score pd-only --scenario no-such": "no-such",
    "export pd-only --to csv --out t": "design pd-only is of kind pd",
    "design --resume": "--resume takes only --out DIR",
    "design --resume --out .": "--out .",
}


@pytest.mark.parametrize("command", COMMANDS)
def test_commands_that_cannot_be_done_leave_nothing(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    line = refused_command(*command.split())
    assert (line.where, line.count("\n")) == (COMMANDS[command], 1)
    assert [*tmp_path.iterdir()] == []


def test_folder_that_cannot_be_made():
    line = refused_command("design", "c-axis-ramp", "--out", "/proc/nothing/run", code=1)
    assert line.where == "/proc/nothing/run"


@pytest.mark.parametrize(
    "text",
    [
        "[plant.parameters]\npoles = 4,0\n",
        "[run]\nseed = 1\nseed = 2\n\n",
        b"\xff\xfe\x00",
    ],
)
def test_what_is_no_toml_is_a_line_of_its_file(text, tmp_path):
    path = tmp_path / "mine.toml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    line = refused_command("design", path)
    assert (line.where, line.count("\n")) == (str(path), 1)


def test_a_file_beside_may_be_meant(tmp_path):
    for name in ("feed2.toml", "c-axis-rump.toml", "mine.json"):
        (tmp_path / name).write_text("")
    for wrong in ("fed2.toml", "feed2"):
        for command in (["design"], ["show", "scenario"]):
            told = refused_command(*command, tmp_path / wrong)
            assert f"did you mean {tmp_path / 'feed2.toml'}?" in told
    refused_command("design", tmp_path / "c-axis-ramp")
    assert refused_command("score", tmp_path / "mine").endswith(f"{tmp_path / 'mine.json'}?\n")


def test_a_name_that_is_that_of_the_file_alone(tmp_path):
    path = tmp_path / "mine+ff.toml"
    path.write_text("[run]\nseed = 1\n")
    assert refused_command("design", path).where == str(path)
    assert load_scenario(path, ["name=mine"]).name == "mine"
    assert refused_command("design", path, "--set", "name=a b").where == str(path)
    assert refused_command("score", path).where == str(path)  # no design


@pytest.mark.parametrize("share", [0.0, 0.3, 0.5, 0.9, 0.999])
def test_design_file_cut_short(share, tmp_path):
    path = tmp_path / "half.json"
    path.write_text(GOOD[: int(len(GOOD) * share)])
    assert refused_command("score", path).where == str(path)


#: Place in the good design -> a value that cannot stand there.
BROKEN = {
    "format": "fis",
    "controller.kind": "mpc",
    "controller.units.1.consequents": [[1.0] * 7] * 6,
    "controller.units.0.row_input": "unit-9",
    "controller.terms.2.label": "f1",
    "name": "../../etc/passwd",
    "plant.parameters.stiffness": -5.0,
}


@pytest.mark.parametrize("key", BROKEN)
def test_a_value_that_a_design_cannot_have(key, tmp_path):
    path = tmp_path / "bad.json"
    path.write_text(json.dumps(overridden(json.loads(GOOD), {key: BROKEN[key]})))
    line = refused_command("score", path)
    assert (line.where, line.count("\n")) == (str(path), 1)


FUZZ = settings(max_examples=100, deadline=None, suppress_health_check=list(HealthCheck))


@FUZZ
@given(st.text(max_size=60))
@example("<class ")
def test_fuzzed_change_is_refused_or_taken(change):
    try:
        assert isinstance(load_scenario("c-axis-ramp", [change]), Scenario)
    except UserError as error:
        plain_lines(error, written=change)


def test_a_mistyped_plant_is_told_beside_its_parameters():
    wrong = {"plant": {"name": "c-axsi", "parameters": {"poles": "many"}}, "name": "x"}
    with refused() as found:
        load_scenario(wrong)
    keys = {line.split(" = ")[0] for line in found.error.lines}
    assert {"scenario: plant.name", "scenario: plant.parameters.poles"} <= keys


@pytest.mark.parametrize(
    "plugins",
    [
        {"plant": {"a": "m:P; touch x"}},
        {"plant": {"a": "-c:P"}},
        ["m:P"],
    ],
)
def test_plugins_of_a_design_are_modules_with_an_object(plugins):
    """They stand in the commands that pages tell."""
    data = json.loads(GOOD)
    data["provenance"]["plugins"] = plugins
    with refused() as found:
        parse_design(json.dumps(data), "d.json")
    assert "\n" not in found.refusal
    data["provenance"]["plugins"] = {"plant": {"a": "some.own-module:Parts.PLANT"}}
    parse_design(json.dumps(data), "d.json")


def test_commands_in_lines_are_those_of_a_shell(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert uses({"plant": {"a": "m:P; touch x", "b": "ü:P"}}) == " --use 'ü:P'"
    (tmp_path / "a; touch x").mkdir()
    refused_command("score", "a; touch x")
    refused_command("score", "$(touch x).fis")
