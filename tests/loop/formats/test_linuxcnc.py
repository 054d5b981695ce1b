"""The folder for LinuxCNC, as far as it can be judged without LinuxCNC."""

import re

import numpy as np
import pytest

from hfc_design.core.records import UserError
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.pairing import load_design
from hfc_design.formats import FORMATS

TABLE_1 = load_design("lin-lee-1999-table-1")
AFLC = load_design("jee-koren-2004-aflc")


def files(design, folder):
    FORMATS["linuxcnc"].write(design, folder)
    found = (path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): path.read_text() for path in found}


def with_controller(design, **changes):
    return design.model_copy(update={"controller": design.controller.model_copy(update=changes)})


def test_machine_moves_last_in_a_sample(tmp_path):
    found = files(AFLC, tmp_path / "a")
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


def test_an_axis_with_a_folder_of_its_own_has_a_loop_of_its_own(tmp_path):
    changes = {"plant.axes": {"x": {}, "y": {}}, "limits.axes.y": {"command": 40.0}}
    found = files(load_design("jee-koren-2004-pid", changes), tmp_path / "a")
    for axis, other, limit in (("x", "y", None), ("y", "x", "40.0")):
        text = found[f"{axis}/loop.hal"] + found[f"{axis}/controller.hal"]
        assert f"names={axis}-machine\n" in text
        assert f"names={axis}-controller\n" in text
        assert f"{other}-" not in text
        assert re.findall(r"^setp .*controller.limit (.*)$", text, re.M) == [limit] * bool(limit)
        rows = np.array([line.split() for line in found[f"{axis}/reference.txt"].splitlines()])
        assert rows.shape[1] == 3
    scenario = load_scenario("feed-drive-circle")
    for k, axis in enumerate("xy"):
        rows = np.loadtxt(found[f"{axis}/reference.txt"].splitlines())
        np.testing.assert_array_equal(rows[:, 0], scenario.samples().axes[k].reference)


@pytest.mark.parametrize(
    ("design", "said"),
    [
        (with_controller(TABLE_1, sample_time_s=2.0), "controller.sample_time_s = 2.0: the period"),
        (
            TABLE_1.model_copy(update={"plant": AFLC.plant.model_copy(update={"name": "lathe"})}),
            "HAL has no component of the plant lathe",
        ),
        (AFLC.model_copy(update={"controller": TABLE_1.controller}), "reads deflection, which is"),
    ],
)
def test_what_hal_cannot_run_is_refused(design, said, tmp_path):
    with pytest.raises(UserError, match=re.escape(said)):
        files(design, tmp_path / "a")
    assert not (tmp_path / "a").exists()
