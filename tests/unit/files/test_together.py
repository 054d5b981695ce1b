"""What designs are called side by side, which machine they share, and what is said to differ."""

import json

from design_files import written
from wording import refused

from hfc_design.files.design_set import differences, labelled, own_machine, shared_machine
from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario


def test_designs_of_one_name_are_called_by_file_folder_or_path(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    given = [written(tmp_path / f"{name}.json", name="b") for name in ("one", "two")]
    assert list(labelled([*given, "pd-only"])) == ["one", "two", "pd-only"]
    for folder in ("runs/c", "runs/d"):
        written(tmp_path / folder / "design.json", name="b")
    assert list(labelled(["runs/c", "runs/d"])) == ["c", "d"]
    written(tmp_path / "other/c/design.json", name="b")
    assert list(labelled(["runs/c", "other/c"])) == ["runs/c", "other/c"]
    deep = [written(tmp_path / f"{way}/b/design.json", name="b") for way in ("runs/a", "runs/x")]
    assert list(labelled(["runs/a/b", "runs/x/b", "runs/c"])) == ["a/b", "x/b", "c"]
    assert list(labelled(deep)) == ["a/b", "x/b"]  # whether the folder is named or its file
    copy = written(tmp_path / "mine/pd-only.json")
    assert list(labelled(["pd-only", copy])) == ["pd-only", "mine/pd-only"]
    nasty = written(tmp_path / "\x1b[2J.v1.json", name="b")
    assert list(labelled([given[0], nasty])) == ["one", "?[2J.v1"]
    design = load_design("pd-only")
    assert list(labelled([design, load_design("pd-only")])) == ["pd-only", "pd-only (2)"]
    assert list(labelled({"mine": "pd-only", "yours": design})) == ["mine", "yours"]


def test_runs_of_a_batch_are_called_as_it_calls_them(tmp_path, monkeypatch):
    """By label and seed, or by what they set; a damaged plan says nothing."""
    monkeypatch.chdir(tmp_path)
    plan = {
        "1a": {"label": "fine\x1b", "run.seed": 0, "search.population": 9},
        "1b": {"label": "fine\x1b", "run.seed": 1, "search.population": 9},
        "1c": {"search.generations": 3, "run.seed": 0, "search.population": 9},
    }
    for name in plan:
        written(tmp_path / "out" / name / "design.json", name="c-axis-ramp")
    (tmp_path / "out" / "batch.json").write_text(json.dumps({"cells": plan}))
    told = ["fine?, seed=0", "fine?, seed=1", "generations=3, seed=0"]
    assert list(labelled([f"out/{name}" for name in plan])) == told
    assert list(labelled(["out/1a/design.json", "pd-only"])) == [told[0], "pd-only"]
    for text in ("{", "[]", '{"cells": {"1a": 3, "1b": {}}}'):
        (tmp_path / "out" / "batch.json").write_text(text)
        assert list(labelled(["out/1a", "out/1c"])) == ["1a", "1c"]


def test_the_same_twice_is_refused(tmp_path):
    file = written(tmp_path / "one.json")
    (tmp_path / "link.json").symlink_to(file)
    for twice in (["pd-only", "pd-only"], [file, tmp_path / "link.json"], [load_design(file)] * 2):
        with refused():
            labelled(twice)


def test_the_machine_is_that_of_the_first_design(tmp_path):
    heavy = load_design(
        written(tmp_path / "h.json", changes={"plant.parameters.spindle_inertia": 9.0})
    )
    plain = load_design("pd-only")
    scenario = load_scenario("c-axis-ramp", {"plant.parameters.stiffness": 300.0})
    shared = shared_machine({"a": heavy, "b": plain}, scenario)
    (parameters,) = shared.plant.values()
    assert (parameters.spindle_inertia, parameters.stiffness) == (9.0, 300.0)
    assert list(differences(heavy, scenario, shared)) == []
    told = "all on the machine of a: spindle_inertia 9.0, in the scenario 5.102 kg m2"
    assert own_machine("a", scenario, shared) == told
    assert own_machine("b", scenario, shared_machine({"b": plain}, scenario)) is None
    (told,) = differences(plain, scenario, shared)
    assert told == "made for another machine: spindle_inertia 5.102, here 9.0 kg m2"


def test_own_limits_are_kept_and_other_sensors_said(tmp_path):
    scenario = {"sensors": {"encoder_resolution": 1e-6}, "limits": {"command": 120.0}}
    own = {"limits": {"command": 90.0}, "provenance": {"scenario": scenario}}
    design = load_design(written(tmp_path / "d.json", **own))
    here = load_scenario("c-axis-ramp", {"limits.command": 100.0})
    found = list(differences(design, here, shared_machine({"d": design}, here)))
    assert found == [
        "the controller applies its own limits: command 90.0, here 100.0 V",
        "made with other drive limits: command 120.0, here 100.0 V",
        "made with other sensors: encoder_resolution 1e-06, here 0.0",
    ]
