"""A design takes along the files that its scenario names: it can be used in any folder."""

import hashlib
import json
import shutil

import numpy as np
import pytest
from carried_files import CUT, SOURCE, WAY
from run_folders import hfc
from wording import refused, refused_command

from hfc_design.files.design import design_json, named_design
from hfc_design.files.loop_setup import load_design, own_scenario
from hfc_design.files.named_scenario import load_scenario, scenario_of
from hfc_design.files.transfer import transfer_report
from hfc_design.runs.individuals import design_with
from hfc_design.runs.run import new_run
from hfc_design.simulation.evaluating import evaluate


def edited(file, change):
    data = json.loads(file.read_text())
    change(data["provenance"]["scenario"])
    file.write_text(json.dumps(data))


def test_it_holds_every_byte_and_its_hash(carried):
    told = load_design(carried[0]).provenance["scenario"]
    assert told["reference"]["file"] == {
        "name": "way.csv",
        "sha256": hashlib.sha256(WAY.encode()).hexdigest(),
        "text": WAY,
    }
    assert told["load"]["file"]["text"] == CUT


def test_every_command_has_what_it_needs(carried):
    found = load_design("mine.json")
    assert evaluate(found, own_scenario(found, "x")).fitness == carried[1]
    for command in (
        ["simulate", "mine.json", "--csv", "motion.csv"],
        ["export", "mine.json", "--to", "linuxcnc", "--out", "hal"],
    ):
        done = hfc(*command)
        assert done.exit_code == 0, done.output
    rows = np.genfromtxt("motion.csv", delimiter=",", names=True)
    assert rows["reference_rad"][[0, 50]] == pytest.approx([0.0, 0.001])
    assert rows["load_torque_Nm"][25] == pytest.approx(0.5, abs=0.02)
    hal = np.loadtxt(carried[0].parent / "hal" / "reference.txt")
    assert hal[:, 0] == pytest.approx(rows["reference_rad"], abs=1e-12)


def test_a_run_of_its_scenario_has_the_files_again(carried):
    found = load_design("mine.json")
    scenario = new_run(own_scenario(found, "mine.json"), carried[0].parent / "run")
    assert (carried[0].parent / "run" / "reference.csv").read_bytes() == WAY.encode()
    again = design_with(SOURCE, scenario).provenance["scenario"]
    assert again["reference"]["file"]["text"] == WAY
    assert again["load"]["file"]["sha256"] == hashlib.sha256(CUT.encode()).hexdigest()


def test_files_of_motions_and_axes_are_taken_along_too(own_tables, tmp_path):
    table = {"kind": "csv", "file": "way.csv"}
    axes = {"x": table, "y": {"kind": "step", "height": 1.0}}
    other = {"x": {"kind": "step", "height": 2.0}, "y": table}
    motions = [
        {"name": "one", "load": {"axes": {"y": {"file": "cut.csv"}}}},
        {"name": "two", "reference": {"kind": "per-axis", "axes": other}},
    ]
    data = {"plant": {"name": "feed-drive", "axes": {"x": {}, "y": {}}}, "motions": motions}
    data |= {"name": "two-axes", "reference": {"kind": "per-axis", "axes": axes}}
    data |= {
        "simulation": {"duration_s": 0.5, "sample_time_s": 0.01},
        "controller": {"kind": "pid"},
    }
    scenario = scenario_of(data | {"fitness": {"kind": "tolerances"}}, "mine.toml", own_tables)
    own = new_run(scenario, tmp_path / "run")
    files = {"reference-x.csv", "one.load-y.csv", "two.reference-y.csv"}
    assert {path.name for path in (tmp_path / "run").iterdir()} == {"config.toml", *files}
    pid = named_design("jee-koren-2004-pid").controller.model_dump(mode="json")
    design = design_with(pid, own)
    first = evaluate(design, own.each_motion()[1]).fitness
    shutil.rmtree(own_tables)
    shutil.rmtree(tmp_path / "run")
    assert design_json(design).count('"sha256"') == 3
    assert evaluate(design, own_scenario(design, "x").each_motion()[1]).fitness == first


def test_a_program_is_taken_along():
    scenario = load_scenario("feed-drive-contour")
    flc = named_design("jee-koren-2004-flc").controller.model_dump(mode="json")
    told = design_with(flc, scenario).provenance["scenario"]["reference"]["file"]
    assert told["name"] == "feed-drive-contour.ngc"
    assert told["text"] == scenario.reference.file.read_text()
    again = own_scenario(design_with(flc, scenario), "x")
    np.testing.assert_array_equal(again.samples().axes[0].target, scenario.samples().axes[0].target)


def test_a_file_that_somebody_has_changed_is_refused(carried):
    edited(carried[0], lambda told: told["reference"]["file"].update(text="0,0\n1,1\n"))
    assert "provenance.scenario: reference.file" in refused_command("score", "mine.json")


@pytest.mark.parametrize(
    "name",
    [
        "../way.csv",
        "/etc/passwd",
    ],
)
def test_a_name_that_leads_elsewhere_is_refused(carried, name):
    edited(carried[0], lambda told: told["reference"]["file"].update(name=name))
    with refused():
        own_scenario(load_design("mine.json"), "mine.json")


def test_a_design_with_a_name_alone_takes_along_what_lies_beside_it(carried):
    file, fitness = carried
    edited(file, lambda told: told["reference"].update(file="way.csv"))
    (file.parent / "way.csv").write_bytes(WAY.encode())
    found = load_design("mine.json")
    (file.parent / "way.csv").unlink()
    assert evaluate(found, own_scenario(found, "elsewhere.json")).fitness == fitness
    edited(file, lambda told: told["reference"].update(file="../here/mine.json"))
    told = load_design("mine.json").provenance["scenario"]["reference"]["file"]
    assert told == "../here/mine.json"  # of what lies elsewhere nothing is taken
    edited(file, lambda told: told["reference"].update(file="way.csv"))
    gone = load_design("mine.json")
    with refused():
        own_scenario(gone, "mine.json")


def test_a_load_is_kept_where_the_file_holds_the_same(carried):
    found, (file, _) = load_design("mine.json"), carried
    (file.parent / "same.csv").write_text(CUT)
    (file.parent / "other.csv").write_text(CUT + "0.1,2\n")
    told = [
        transfer_report(
            found, scenario_of({"name": "n", "load": {"file": name}}, "n", file.parent)
        )[-1]
        for name in ("same.csv", "other.csv")
    ]
    assert told[0].split() == ["load", "kept"]
    assert "file sha256-" in told[1]
    assert len(told[1]) < 200
