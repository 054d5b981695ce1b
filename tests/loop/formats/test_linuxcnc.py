"""The folder for LinuxCNC of a feed drive, as far as it can be judged without LinuxCNC."""

import re

import numpy as np
import pytest
from exported import table, texts, with_controller, with_scenario
from wording import refused

from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario

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
