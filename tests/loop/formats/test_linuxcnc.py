"""The folder for LinuxCNC of a feed drive, as far as it can be judged without LinuxCNC."""

import re
import xml.etree.ElementTree as ET

import made_up
import numpy as np
import pytest
from deployment_folders import ALL, FEW, runs_in_a_plc, vectors
from exported import table, texts, with_controller, with_scenario
from plcopen_project import PPX, block_in, function_block, pous
from structured_text import FunctionBlock
from wiring import silent
from wording import refused

from hfc_design.files.design import named_design
from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.formats import code
from hfc_design.formats.plcopen import project
from hfc_design.formats.st import text_of

TABLE_1 = load_design("lin-lee-1999-table-1")
FLC = load_design("jee-koren-2004-flc")


def files(design):
    return texts(design, "linuxcnc")


def test_a_loop_of_two_axes():
    """The machines move last in a sample, and have the coefficients of their parameters."""
    found = files(FLC)
    text = found["loop.hal"].replace("source controller.hal", found["controller.hal"])
    assert re.findall(r"^addf (\S+) servo-thread", text, re.M) == [
        "streamer.0",
        "x-controller",
        "y-controller",
        "sampler.0",
        "x-machine",
        "y-machine",
    ]
    assert "period1=10000000\n" in text
    assert "setp x-machine.positive-start 6.54\n" in text
    assert "setp y-machine.positive-start 7.23\n" in text
    assert "setp y-machine.negative-start 5.04\n" in text
    assert "and not in mm: 1 BLU is 0.01 mm:" in found["README.md"]
    fine = FLC.plant.model_copy(update={"parameters": {"blu": 0.002}})
    page = files(FLC.model_copy(update={"plant": fine}))["README.md"]
    assert "1 BLU is 0.002 mm:" in page


def test_an_axis_with_a_folder_of_its_own_has_a_loop_of_its_own():
    changes = {"plant.axes": {"x": {}, "y": {}}, "limits.axes.y": {"command": 40.0}}
    found = files(load_design("jee-koren-2004-pid", changes))
    circle = load_scenario("feed-drive-circle").samples()
    for k, (axis, other, limit) in enumerate((("x", "y", []), ("y", "x", ["40.0"]))):
        text = found[f"{axis}/loop.hal"] + found[f"{axis}/controller.hal"]
        assert f"names={axis}-machine\n" in text
        assert f"names={axis}-controller\n" in text
        assert f"{other}-" not in text
        law = found[f"{axis}/jee_koren_2004_pid_{axis}.c"]
        assert re.findall(r" own = R\((.*)\);", law) == limit
        rows = table(found[f"{axis}/reference.txt"])
        assert rows.shape[1] == 3
        np.testing.assert_array_equal(rows[:, 0], circle.axes[k].reference)


def test_a_component_reads_the_encoder_that_the_scenario_feeds_back():
    """Of the whole machine only one; what has a folder for each axis reads the own of each."""
    pid, loop = load_design("huang-pid"), ("milling-table-circle", "simulation.duration_s=1")
    both = files(with_scenario(pid, *loop, "sensors.feedback=motor_position"))
    assert "net x-motor-position <= x-machine.motor-position\n" in both["loop.hal"]
    assert "net x-true-position x-machine.true-position =>" in both["loop.hal"]
    assert "`error` | out | mm | reference less motor-position |" in both["README.md"]
    one = (*loop, "sensors.axes.y.feedback=motor_position")
    with refused():
        files(with_scenario(pid, *one))
    own = {"plant.axes": {"x": {}, "y": {}}, "limits.axes.y": {"command": 10.0}}
    apart = files(with_scenario(load_design("huang-pid", own), *one))
    for axis, pin in {"x": "position", "y": "motor-position"}.items():
        assert f"net {axis}-{pin} <= {axis}-machine.{pin}\n" in apart[f"{axis}/loop.hal"]


def test_without_a_scenario_that_fits_there_is_a_controller_and_a_reason():
    found = files(with_controller(FLC, sample_time_s=0.001).model_copy(update={"provenance": {}}))
    assert found.keys().isdisjoint({"loop.hal", "reference.txt", "hfc_feed_drive.comp"})
    assert (
        "controller.start: must have the sample time simulation.sample_time_s" in found["README.md"]
    )
    assert "loadrt hfc_jee_koren_2004_flc names=controller\n" in found["controller.hal"]


@pytest.mark.parametrize(
    "design",
    [
        with_controller(TABLE_1, sample_time_s=2.0),
        TABLE_1.model_copy(update={"plant": FLC.plant.model_copy(update={"name": "lathe"})}),
        FLC.model_copy(update={"controller": TABLE_1.controller}),
    ],
    ids=["period", "plant", "signal"],
)
def test_what_hal_cannot_run_is_refused(design):
    with refused():
        files(design)


@pytest.mark.parametrize("name", FEW)
def test_the_page_names_every_signal_its_unit_and_how_large_it_was(name):
    found = texts(ALL[name], "c")
    names, numbers, _ = vectors(found)
    largest = dict(zip(names, np.abs(numbers).max(axis=0), strict=True))
    rows = re.findall(r"\| `(\w+)` \| (in|out) \| (\S+) \| (\S+) \| \w", found["README.md"])
    wanted = {(name, "in", unit) for name, unit in code.signals(ALL[name]).items()}
    assert wanted < {row[:3] for row in rows}
    assert all(unit for _, _, unit in wanted)
    assert {row[:2] for row in rows} - {row[:2] for row in wanted} == {("command", "out")}
    for signal, _, _, told in rows:
        ends = [x for key, x in largest.items() if key.rpartition(".")[2] == signal]
        assert float(told) == pytest.approx(max(ends), rel=6e-3)


@pytest.mark.parametrize("name", ["jee-koren-2004-flc", "jee-koren-1995-fit-flc"])
def test_every_rule_of_a_table_fires(name):
    """Judged by centres: error and its change come nearer to those of every rule than the next."""
    names, numbers, _ = vectors(texts(ALL[name], "c"))
    record = ALL[name].controller
    error = numbers[:, names.index("error")]
    change = np.diff(error, prepend=0.0)
    places = []
    for terms, values in ((record.error_terms, error), (record.error_change_terms, change)):
        centres = np.array([term.centre for term in terms])
        places.append(np.abs(values[:, None] - centres).argmin(axis=1))
    count = len(record.error_terms) * len(record.error_change_terms)
    assert len(set(zip(*places, strict=True))) == count


def test_a_plc_runs_the_vectors_and_a_project_has_the_same():
    design = ALL["jee-koren-2004-flc"]
    runs_in_a_plc(design)
    block, project = texts(design, "st"), texts(design, "plcopen")
    checks = {"check/check.st", "check/vectors.csv"}
    assert {file: project[file] for file in checks} == {file: block[file] for file in checks}
    assert project.keys() == checks | {"README.md", "jee_koren_2004_flc.xml"}


CASES = {
    "pd": named_design("pd-only"),
    "hierarchy": made_up.hierarchy(1),
    "flc with options": made_up.with_options("flc", 3),
    "lqi within a limit": made_up.limited(made_up.linear("lqi", 2), 400.0),
    "scheduling": made_up.limited(made_up.scheduling(5), 60.0),
    "silent": silent(),
}


@pytest.mark.parametrize("case", CASES)
def test_the_block_of_a_project_is_that_of_structured_text(case):
    record = CASES[case]
    name, sections, body = block_in(project(record))
    written = text_of(record)
    here, there = FunctionBlock(function_block(name, sections, body)), FunctionBlock(written)
    assert (here.block, here.values, here.kinds) == (there.block, there.values, there.kinds)
    assert here.inputs == there.inputs
    assert body in written
    assert body.endswith("fault := FALSE;\n")


def test_a_task_calls_the_block_once_a_sample():
    record = made_up.linear("lqr", 3, "feed-drive")
    every = record.controller.model_copy(update={"sample_time_s": 0.0025})
    text = project(record.model_copy(update={"controller": every}))
    task = ET.fromstring(text).find(f".//{PPX}task")
    assert task.get("interval") == "T#2.5ms"
    program = task.find(f"{PPX}pouInstance").get("typeName")
    kind, sections, body = pous(text)[program]
    name, block = sections["localVars"][0][:2]
    assert (kind, pous(text)[block][0]) == ("program", "functionBlock")
    assert body.startswith(f"{name}(reset := FALSE, error := error, ")
    given = {item.split(" := ")[0] for item in body.partition(")")[0].split("(")[1].split(", ")}
    assert given == {one[0] for one in pous(text)[block][1]["inputVars"]}
    assert given - {"reset"} < {one[0] for one in sections["localVars"]}
    assert body.endswith(f"command := {name}.command;\nfault := {name}.fault;\n")
