"""What a user gets wrong: one clear line, the right exit code, and nothing lost."""

import json

import pytest
from click.testing import CliRunner
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from plain_words import plain_lines

from hfc_design.cli import main
from hfc_design.core.records import UserError
from hfc_design.files.design import Design, design_json, parse_design
from hfc_design.files.named_scenario import load_scenario, scenario_toml
from hfc_design.files.pairing import load_design
from hfc_design.files.scenario import Scenario

GOOD = design_json(load_design("lin-lee-1999-table-1"))


def refused(*arguments, code=2):
    """The one line that a command refuses with."""
    done = CliRunner().invoke(main, [str(argument) for argument in arguments])
    assert done.exit_code == code, done.output
    assert done.stdout == ""
    assert done.stderr.startswith("hfc: ")
    assert done.stderr.count("\n") == 1
    return done.stderr


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("plant.parameters.spindle_inertia=-1", ["spindle_inertia = -1.0", "more than zero"]),
        ("plant.parameters.spindle_mass=1", ["spindle_mass", "unknown", "spindle_inertia"]),
        ("plant.parameters.mutual_inductance=9", ["mutual_inductance", "stator_inductance"]),
        ("plant.name=d-axis", ["plant.name = 'd-axis'", "c-axis"]),
        ("simulation.sample_time_s=0", ["simulation.sample_time_s = 0", "greater than 0"]),
        ("simulation.duration_s=nan", ["simulation.duration_s = nan", "finite"]),
        ("simulation.duration_s=1e9", ["samples", "10000000"]),
        ("load.constant=inf", ["load.constant = inf", "finite"]),
        ("search.population=0", ["search.population = 0", "has to be 1 or more"]),
        ("search.generations=-3", ["search.generations = -3"]),
        ("search.preset=magic", ["'magic'", "race", "lin-lee-1999"]),
        ("search.kp_range=[5,1]", ["kp_range", "[low, high]"]),
        ("reference.kind=wiggle", ["reference.kind = 'wiggle': is no kind", "ramp"]),
        ("reference.speed=3", ["reference.speed", "no such key"]),
        ("controller.inputs=[{name='error',scale=1.0},{name='mood',scale=1.0}]", ["'mood'"]),
        ("controller.inputs=[{name='error',scale=1.0}]", ["controller.inputs", "at least 2"]),
        ("fitness.error=-1", ["fitness.error = -1"]),
        ("nonsense=1", ["nonsense = 1", "no such key"]),
        ("duration", ["has to look like"]),
        ("name.first=x", ["name is not a table"]),
    ],
)
def test_values_that_are_not_allowed(change, words, tmp_path):
    line = refused("design", "c-axis-ramp", "--out", tmp_path / "run", "--set", change)
    for word in words:
        assert word in line
    assert not (tmp_path / "run").exists()


def test_population_zero_by_its_option(tmp_path):
    assert "search.population = 0" in refused(
        "design", "c-axis-ramp", "--population", "0", "--out", tmp_path / "r"
    )


def test_unknown_names():
    assert "c-axis-ramp-cutting" in refused("design", "no-such-scenario")
    assert "lin-lee-1999-table-1" in refused("score", "no-such-design")
    assert "c, csv, fcl, " in refused("export", "pd-only", "--to", "pdf")
    assert "no-such" in refused("score", "pd-only", "--scenario", "no-such")


@pytest.mark.parametrize(
    ("text", "hint"),
    [
        (
            "[plant.parameters]\npoles = 4,0\n",
            "(at line 2, column 10); a number has a decimal point",
        ),
        ("[run]\nseed = 1\nseed = 2\n\n", "; seed is given twice"),
        ("[run]\nseed = 1\nseed = 2", "; seed is given twice"),
        ("[run]\nseed = [1,2\n", ""),
    ],
)
def test_common_mistakes_of_toml_are_told(text, hint, tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(text)
    line = refused("design", path)
    assert "mine.toml: is not valid TOML: " in line
    assert hint in line
    assert hint or ";" not in line


def test_a_file_beside_may_be_meant(tmp_path):
    for name in ("feed2.toml", "c-axis-rump.toml", "mine.json"):
        (tmp_path / name).write_text("")
    for wrong in ("fed2.toml", "feed2"):
        meant = f"no such file or scenario; did you mean {tmp_path / 'feed2.toml'}?\n"
        for command in (["design"], ["show", "scenario"]):
            assert refused(*command, tmp_path / wrong).endswith(f"{wrong}: {meant}")
    assert "mean c-axis-ramp? built in are" in refused("design", tmp_path / "c-axis-ramp")
    assert refused("score", tmp_path / "mine").endswith(f"mean {tmp_path / 'mine.json'}?\n")


def test_a_name_that_is_that_of_the_file_alone(tmp_path):
    path = tmp_path / "mine+ff.toml"
    path.write_text("[run]\nseed = 1\n")
    line = refused("design", path)
    assert "mine+ff.toml: the name of the file cannot be that of the scenario, which has" in line
    assert line.endswith("give the scenario one, as in name = 'mine'\n")
    assert load_scenario(path, ["name=mine"]).name == "mine"
    assert "name = 'a b': has to be 1 to 64" in refused("design", path, "--set", "name=a b")


def test_a_scenario_where_a_design_is_wanted(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text("[run]\nseed = 1\n")
    assert "mine.toml: is TOML, as a scenario, and no design; hfc design" in refused("score", path)


def test_malformed_toml_names_file_and_line(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text("[plant\nname = 3\n")
    line = refused("design", path)
    assert "mine.toml: is not valid TOML" in line
    assert "line 1" in line


def test_binary_rubbish_as_scenario(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_bytes(b"\xff\xfe\x00")
    assert "mine.toml: cannot be read" in refused("design", path)


def test_csv_export_of_a_design_without_tables(tmp_path):
    line = refused("export", "pd-only", "--to", "csv", "--out", tmp_path / "t")
    assert "no rule tables" in line


def test_folder_that_cannot_be_made():
    line = refused("design", "c-axis-ramp", "--out", "/proc/nothing/run", code=1)
    assert "/proc/nothing/run: cannot be written" in line


def test_resume_takes_no_other_options(tmp_path):
    assert "--resume needs --out" in refused("design", "--resume")
    assert "--resume needs --out" in refused("design", "--resume", "--out", tmp_path, "--seed", "1")
    assert "holds no run" in refused("design", "--resume", "--out", tmp_path)


def test_scenario_for_another_sample_time():
    line = refused("score", "pd-only", "--set", "simulation.sample_time_s=0.002")
    assert "simulation.sample_time_s = 0.002" in line


@pytest.mark.parametrize("share", [0.0, 0.3, 0.5, 0.9, 0.999])
def test_design_file_cut_short(share, tmp_path):
    path = tmp_path / "half.json"
    path.write_text(GOOD[: int(len(GOOD) * share)])
    assert "half.json: is not a whole JSON file" in refused("score", path)


def broken(*keys, value):
    """The good design with one value replaced, as text."""
    data = json.loads(GOOD)
    place = data
    for key in keys[:-1]:
        place = place[key]
    place[keys[-1]] = value
    return json.dumps(data)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (broken("format", value="fis"), ["format = 'fis'", "hfc-design"]),
        (broken("version", value=2), ["version = 2"]),
        (broken("controller", "kind", value="mpc"), ["'mpc'", "aflc"]),
        (broken("controller", "pd", "kp", value=float("nan")), ["NaN"]),
        (broken("controller", "pd", "kp", value="much"), ["controller.pd.kp = 'much'"]),
        (
            broken("controller", "units", 1, "consequents", value=[[1.0] * 7] * 6),
            ["controller.units.1.consequents", "at least 7"],
        ),
        (
            broken("controller", "units", 0, "consequents", 3, value=[1.0] * 8),
            ["controller.units.0.consequents.3", "at most 7"],
        ),
        (broken("controller", "units", 0, "row_input", value="unit-9"), ["unit 7 reads 'unit-9'"]),
        (
            broken("controller", "units", 1, "row_input", value="spindle_velocity"),
            ["unit 3 reads 'spindle_velocity'"],
        ),
        (broken("controller", "terms", 2, "label", value="f1"), ["terms", "twice"]),
        (broken("controller", "terms", 2, "label", value='x"); evil('), ["label"]),
        (broken("name", value="../../etc/passwd"), ["name"]),
        (broken("plant", "name", value="lathe"), ["lathe"]),
        (broken("plant", "parameters", "stiffness", value=-5.0), ["stiffness = -5.0"]),
        ("[" * 100_000, ["is not a whole JSON file"]),
        ("3", ["table of keys"]),
    ],
)
def test_design_files_that_cannot_run(text, words, tmp_path):
    path = tmp_path / "bad.json"
    path.write_text(text)
    line = refused("score", path)
    for word in ["bad.json", *words]:
        assert word in line


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


FUZZ = settings(max_examples=300, deadline=None, suppress_health_check=list(HealthCheck))


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
    import tomllib

    import tomli_w

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
    with pytest.raises(UserError) as told:
        load_scenario(wrong)
    lines = told.value.lines
    assert any(
        "plant.name = 'c-axsi': is no plant known here; did you mean c-axis?" in x for x in lines
    )
    assert any("plant.parameters.poles = 'many': has to be a number" in x for x in lines)
