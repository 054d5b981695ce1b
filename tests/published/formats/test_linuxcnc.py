"""The folder for LinuxCNC, as far as it can be judged without LinuxCNC."""

import re

import pytest

from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.pairing import load_design
from hfc_design.formats import FORMATS

TABLE_1 = load_design("lin-lee-1999-table-1")
AFLC = load_design("jee-koren-2004-aflc")


def files(design, folder):
    FORMATS["linuxcnc"].write(design, folder)
    found = (path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): path.read_text() for path in found}


def with_scenario(design, name, *changes):
    scenario = load_scenario(name, changes).model_dump(mode="json", exclude_none=True)
    return design.model_copy(update={"provenance": {"scenario": scenario}})


def with_controller(design, **changes):
    return design.model_copy(update={"controller": design.controller.model_copy(update=changes)})


def test_folder_holds_all_and_is_the_same_each_time(tmp_path):
    found = files(AFLC, tmp_path / "a")
    assert found == files(AFLC, tmp_path / "b")
    assert set(found) == {
        "Makefile",
        "README.md",
        "check/check.c",
        "check/vectors.csv",
        "controller.hal",
        "hfc_feed_drive.comp",
        "hfc_jee_koren_2004_aflc.comp",
        "jee_koren_2004_aflc.c",
        "jee_koren_2004_aflc.h",
        "loop.hal",
        "plant_feed_drive.c",
        "plant_feed_drive.h",
        "reference.txt",
    }


def test_the_unit_of_the_pins_is_told(tmp_path):
    assert "and not in degrees:" in files(TABLE_1, tmp_path / "c")["README.md"]
    assert "and not in mm: 1 BLU is 0.01 mm:" in files(AFLC, tmp_path / "a")["README.md"]
    fine = AFLC.model_copy(
        update={"plant": AFLC.plant.model_copy(update={"parameters": {"blu": 0.002}})}
    )
    assert "1 BLU is 0.002 mm:" in files(fine, tmp_path / "f")["README.md"]


def test_machine_has_the_coefficients_of_its_parameters(tmp_path):
    changed = with_scenario(TABLE_1, "c-axis-ramp", "plant.parameters.spindle_inertia=6.5")
    text = files(changed, tmp_path / "a")["loop.hal"]
    leakage = 0.341 - 0.225**2 / 0.306
    for name, value in {
        "current-decay": (1.12 + 1.05 * 0.341 / 0.306) / leakage,
        "torque-constant": 0.225 * 0.6 / 0.306,
        "inverse-spindle-inertia": 1 / 6.5,
        "friction-stribeck-rise": 0.5,
    }.items():
        (found,) = re.findall(rf"^setp machine\.{name} (\S+)$", text, re.M)
        assert float(found) == pytest.approx(value, rel=1e-14)
    axes = files(AFLC, tmp_path / "b")["loop.hal"]
    assert "setp x-machine.positive-start 6.54\n" in axes
    assert "setp y-machine.positive-start 7.23\n" in axes
    assert "setp y-machine.negative-start 5.04\n" in axes


def test_without_a_scenario_that_fits_there_is_a_controller_and_a_reason(tmp_path):
    design = with_controller(AFLC, sample_time_s=0.001).model_copy(update={"provenance": {}})
    found = files(design, tmp_path / "a")
    assert found.keys().isdisjoint({"loop.hal", "reference.txt", "hfc_feed_drive.comp"})
    assert "controller.start: runs every 0.01 s, simulation.sample_time_s is" in found["README.md"]
    assert "loadrt hfc_jee_koren_2004_aflc names=controller\n" in found["controller.hal"]
