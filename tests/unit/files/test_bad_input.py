"""What a user gets wrong: one clear line, the right exit code, and nothing lost."""

import json
import re
import tomllib

import pytest
import tomli_w
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from plain_words import plain_lines
from wording import refused, refused_command

from hfc_design.core.overrides import overridden
from hfc_design.core.plugins import uses
from hfc_design.core.records import UserError
from hfc_design.files.design import Design, design_json, parse_design
from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario, scenario_toml
from hfc_design.files.scenario import Scenario

GOOD = design_json(load_design("lin-lee-1999-table-1"))


#: Changes of c-axis-ramp, the last of which is at fault.
CHANGES = [
    ["simulation.duration_s=0"],
    ["run.seed=1.5"],
    ["run.precision='float23'"],
    ["search.population='many'"],
    ["sensors.velocity='tacho'"],
    ["name='a b'"],
    ["windows=[{name='A'}]"],
    ["start={velocity='x'}"],
    ["reference={velocity=1}"],
    ["limits.axes.x.comand=1"],
    ["limits.axes.x.command=-1"],
    ["limits.axes.1x={}"],
    ["controller.kind=pidd"],
    ["search.population=true"],
    ["limits.command=true"],
    ["plant.parameters.poles=true"],
    ["start={velocity=true}"],
    ["plant.parameters.stator_inductance='4.7 mH'"],
    ["sensors.axes.x.noise='1 mrad'"],
    ["simulation.duration_s='2 s'"],
    ["limits.command='2 kg'"],
    ["poles=2"],
    ["fitness.tolerances={}"],
    ["robustness.spread=0.1"],
    ["plant.poles=2"],
    ["run.precision='FLOAT32'"],
    ["controller.kind='PID'"],
    ["constraints.max_eror=1"],
    ["run.precision=1"],
    ["load.constant='x'"],
    ["search.preset=rase"],
    ["plant.parameters.spindle_mas=1"],
    ["plant.parameters.spindle_inertia=-1"],
    ["plant.parameters.spindle_mass=1"],
    ["plant.parameters.mutual_inductance=9"],
    ["plant.name=d-axis"],
    ["simulation.sample_time_s=0"],
    ["simulation.duration_s=nan"],
    ["simulation.duration_s=1e9"],
    ["load.constant=inf"],
    ["search.population=0"],
    ["search.generations=-3"],
    ["search.preset=magic"],
    ["search.kp_range=[5,1]"],
    ["reference.kind=wiggle"],
    ["reference.speed=3"],
    ["controller.inputs=[{name='error',scale=1.0},{name='mood',scale=1.0}]"],
    ["controller.inputs=[{name='error',scale=1.0}]"],
    ["fitness.error=-1"],
    ["nonsense=1"],
    ["limits.delay_samples=true"],
    ["limits.delay_samples=false"],
    ["limits.delay_samples=65"],
    ["simulation.duration_s=0.01", "limits.delay_samples=10"],
    ["robust.tolerances.stifness=0.1"],
    ["robust.tolerances.stiffness=1.5"],
    ["motions=[{name='a'},{name='b',sample_time_s=0.002}]"],
    ["motions=[{name='a'},{name='b',simulation={substeps=2}}]"],
    ["motions=[{name='a'},{name='b',duration_s=2.0,settled_after_s=3.0}]"],
    ["robust.spread=1"],
    ["robust.margin=1.2", "robust.spread=0.9"],
    ["robust.margin=1.2", "robust.tolerances.stiffness=0.9"],
    ["robust.keep=best"],
    ["constraints.speed=1"],
    ["constraints.limit_share=-1"],
    ["constraints.limit_share=nan"],
    ["constraints.late_error='1 kg'"],
    ["constraints.band_time=1"],
    ["constraints.estimated_rms_contour_error=1"],
    ["fitness.kind=fun"],
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
    "design c-axis-ramp --set duration --out run": "--set duration",
    "design c-axis-ramp --set name.first=x --out run": "--set name.first=x",
    "design no-such-scenario": "no-such-scenario",
    "score no-such-design": "no-such-design",
    "score pd-only --scenario no-such": "no-such",
    "export pd-only --to pdf": "--to pdf",
    "export pd-only --to csv --out t": "design pd-only is of kind pd",
    "design --resume": "--resume takes only --out DIR",
    "design --resume --out . --seed 1": "--resume takes only --out DIR",
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
        "[run]\nseed = 1\nseed = 2",
        "[run]\nseed = [1,2\n",
        "[plant\nname = 3\n",
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
    "version": 2,
    "controller.kind": "mpc",
    "controller.pd.kp": "much",
    "controller.units.1.consequents": [[1.0] * 7] * 6,
    "controller.units.0.consequents.3": [1.0] * 8,
    "controller.units.0.row_input": "unit-9",
    "controller.units.1.row_input": "spindle_velocity",
    "controller.terms.2.label": "f1",
    "controller.terms.0.label": 'x"); evil(',
    "name": "../../etc/passwd",
    "plant.name": "lathe",
    "plant.parameters.stiffness": -5.0,
}


@pytest.mark.parametrize("key", BROKEN)
def test_a_value_that_a_design_cannot_have(key, tmp_path):
    path = tmp_path / "bad.json"
    path.write_text(json.dumps(overridden(json.loads(GOOD), {key: BROKEN[key]})))
    line = refused_command("score", path)
    assert (line.where, line.count("\n")) == (str(path), 1)


@pytest.mark.parametrize("text", ["[" * 100_000, "3", GOOD.replace("758.405", "NaN")])
def test_design_files_that_cannot_run(text, tmp_path):
    path = tmp_path / "bad.json"
    path.write_text(text)
    assert refused_command("score", path).where == str(path)


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=8) | st.dictionaries(st.text(max_size=12), inner),
    max_leaves=20,
)


def paths(value, prefix=()):
    """Every place in a JSON value."""
    yield prefix
    if isinstance(value, dict | list):
        for key, part in value.items() if isinstance(value, dict) else enumerate(value):
            yield from paths(part, (*prefix, key))


def replaced(data, path, value):
    if not path:
        return value
    data = data.copy()
    data[path[0]] = replaced(data[path[0]], path[1:], value)
    return data


FUZZ = settings(max_examples=100, deadline=None, suppress_health_check=list(HealthCheck))


@FUZZ
@given(data=st.data())
def test_fuzzed_design_file_is_refused_or_is_a_design(data):
    whole = json.loads(GOOD)
    path = data.draw(st.sampled_from(list(paths(whole))))
    text = json.dumps(replaced(whole, path, data.draw(json_values)))
    try:
        found = parse_design(text, "fuzz.json")
    except UserError as error:
        plain_lines(error, "fuzz.json: ", text)
    else:
        assert isinstance(found, Design)
        assert parse_design(design_json(found), "again.json") == found


@FUZZ
@given(st.binary(max_size=200) | st.text(max_size=200).map(str.encode), st.integers(0, len(GOOD)))
def test_fuzzed_text_in_a_design_file_is_refused_or_is_a_design(rubbish, place):
    text = GOOD[:place] + rubbish.decode(errors="replace") + GOOD[place:]
    try:
        assert isinstance(parse_design(text, "fuzz.json"), Design)
    except UserError as error:
        plain_lines(error, "fuzz.json: ", text)


toml_values = st.recursive(
    st.booleans()
    | st.integers(-(2**63), 2**63 - 1)
    | st.floats()
    | st.text("abc '=[]", max_size=9),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text("abc", min_size=1), inner),
    max_leaves=8,
)


@FUZZ
@given(data=st.data())
def test_fuzzed_scenario_is_refused_or_is_a_scenario(data, tmp_path_factory):
    whole = tomllib.loads(scenario_toml(load_scenario("c-axis-ramp-cutting")))
    path = data.draw(st.sampled_from([p for p in paths(whole) if p]))
    text = tomli_w.dumps(replaced(whole, path, data.draw(toml_values)))
    file = tmp_path_factory.getbasetemp() / "fuzz.toml"
    file.write_text(text)
    try:
        found = load_scenario(str(file))
    except UserError as error:
        plain_lines(error, f"{file}: ", text)
    else:
        assert isinstance(found, Scenario)
        file.write_text(scenario_toml(found))
        assert load_scenario(str(file)) == found


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
        {"plant": {"a": "m"}},
        {"plant": {"a": ["m:P"]}},
        {"plant": "m:P -c"},
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
