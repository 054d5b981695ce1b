"""``config.toml`` of a run holds every key: what is not set stands behind it, commented out."""

import re
import tomllib

from hfc_design.files.named_scenario import config_toml, load_scenario, scenario_toml
from hfc_design.reference.entries import KEY, things
from hfc_design.runs import run


def test_what_is_commented_changes_nothing(tmp_path):
    scenario = load_scenario("c-axis-practical")
    found = run.new_run(scenario, tmp_path / "run")
    assert found == scenario
    text = (tmp_path / "run" / "config.toml").read_text()
    assert tomllib.loads(text) == tomllib.loads(scenario_toml(scenario))


def test_what_is_set_is_explained_in_the_units_of_the_plant():
    changes = {"plant.parameters.stiffness": 300.0, "controller": {"kind": "pid+ff"}}
    scenario = load_scenario("c-axis-practical", changes)
    text = config_toml(scenario)
    before = {}
    for above, line in zip(text.splitlines(), text.splitlines()[1:], strict=False):
        before.setdefault(line.partition(" = ")[0], above)
    assert before["stiffness"] == (
        "# of the transmission, referred to the motor, k [N m/rad]; greater than 0"
    )
    assert before["duration_s"] == "# duration of a motion [s]; greater than 0"
    assert before["amplitude"] == "# amplitude [rad]"  # of a motion
    assert before["root_limit"] == "# |consequent| of a hierarchy's root; greater than 0"
    assert before["[controller]"] == "# controller to search for"
    assert text.count("weight of its cost relative to the others") == 1  # not in each motion
    assert tomllib.loads(text) == tomllib.loads(scenario_toml(scenario))


def test_every_key_is_there(tmp_path):
    text = config_toml(load_scenario("c-axis-ramp"))
    said = {line.split(" =")[0].lstrip("#") for line in text.splitlines() if " = " in line}
    heads = set(re.findall(r"^#?\[+([\w.-]+)\]+$", text, re.MULTILINE))
    for table in ("robust", "constraints", "motions", "windows", "start", "controller.linear"):
        assert table in heads or table in said
    assert {"polish", "spread", "unseen", "observer_hz", "command_rate", "delay_samples"} <= said
    for one in things(KEY):
        parts = [part for part in one.key.split(".") if part != "N"]
        if {"AXIS", "NAME"} & {*parts} or one.key.startswith(("load.sines.N.", "stress.modes.N.")):
            continue
        assert parts[-1] in said | heads or ".".join(parts) in heads, one.key


def test_what_is_set_is_not_told_again():
    text = config_toml(load_scenario("c-axis-practical")).partition("# Keys that are not set")[2]
    assert "#spread" not in text  # [robust] is set
    assert "[[motions]]" not in text
    assert "#weight" not in text
    assert "#polish = 0" in text
