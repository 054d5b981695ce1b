"""FLL, FCL and FML without the programs that they are for.

JFML and jFuzzyLogic are on none of PyPI, Debian and npm, where make interop installs from. So FML
is read by fml_oracle.py and FCL by fcl_oracle.py of tests/helpers: readers of their own, written
from the standards and from what those two programs accept. Measured, worst of all designs and
relative to the largest output: FML 7e-16 in double precision, 7e-7 in the single precision that
JFML reckons in; FCL of jFuzzyLogic 8e-16; FCL of IEC 61131-7 4e-4 with polygons, 3e-16 with
triangles.
"""

import json
from functools import partial

import numpy as np
import pytest
from fml_oracle import System
from wiring import (
    command,
    controller_error,
    random_signals,
)

from hfc_design.core.records import UserError
from hfc_design.files.design import Design, named_design
from hfc_design.files.pairing import load_design
from hfc_design.formats import FORMATS

LANGUAGES = ["fll", "fcl", "fcl-jfuzzylogic", "fml"]
EVIL = 'x); system("id") *)\n-->'


def written(record, target, folder):
    FORMATS[target].write(record, folder)
    return folder


def read(reader, file, row, column, points):
    system = reader(file)
    low, high = np.transpose([system.domain(name) for name in (row, column)])
    points = np.clip(points, low, high)
    return system.evaluate(**{row: points[:, 0], column: points[:, 1]})


LOW_VELOCITY = {
    "forward": [1.5, -2.0, 7.0],
    "backward": [-1.0, 0.5, -7.0],
    "highest_velocity_mm_s": 3.0,
    "breakaway": [8.0, -9.0],
    "smallest_error": 1.0,
}


@pytest.mark.parametrize("blu", [{}, {"blu_mm": 0.004}])
@pytest.mark.parametrize("form", ["P", "PI", "PD"])
def test_the_files_alone_give_the_command_of_every_form(form, blu, tmp_path):
    data = named_design("jee-koren-2004-flc").model_dump(mode="json")
    data["controller"] |= {"form": form, "integral_gain": 2.5, "low_velocity": LOW_VELOCITY | blu}
    record = Design.model_validate(data)
    folder = written(record, "fml", tmp_path / "x")
    assert controller_error(record, folder, partial(read, System)) <= 1e-12
    assert ("the change of the command" in (folder / "rules.fml").read_text()) == (form == "PI")


@pytest.mark.parametrize("form", ["P", "PI", "PD", "table 1"])
def test_the_files_alone_keep_the_limit_of_a_design(form, tmp_path):
    name = "lin-lee-1999-table-1" if form == "table 1" else "jee-koren-2004-flc"
    data = named_design(name).model_dump(mode="json")
    if form != "table 1":
        data["controller"] |= {"form": form, "integral_gain": 4.0, "low_velocity": LOW_VELOCITY}
    data["limits"] = {"command": 12.0}
    record = Design.model_validate(data)
    folder = written(record, "fml", tmp_path / "x")
    assert controller_error(record, folder, partial(read, System)) <= 1e-12
    steps = json.loads((folder / "controller.json").read_text())["steps"]
    assert steps[-1] == "command = min(max(command, -largest_command), largest_command)"
    assert any("stays as it was" in step for step in steps) == (form != "table 1")


@pytest.mark.parametrize("name", ["lin-lee-1999-table-1", "jee-koren-2004-flc"])
def test_the_files_alone_keep_the_rate_of_a_design(name, tmp_path):
    limits = {"command": 12.0, "command_rate": 2.0 / named_design(name).controller.sample_time_s}
    record = load_design(name, {"limits": limits})
    folder = written(record, "fll", tmp_path / "x")
    about = json.loads((folder / "controller.json").read_text())
    assert about["largest_change"] == 2.0
    assert about["steps"][-1].startswith("command = min(max(command, previous_command - largest_")
    found = command(folder, random_signals(record, 100), lambda *_: np.full(100, 1e9))
    assert [*found[:6]] == [2.0, 4.0, 6.0, 8.0, 10.0, 12.0]


@pytest.mark.parametrize("target", LANGUAGES)
def test_an_adaptive_controller_says_that_its_table_is_a_start(target, tmp_path):
    written(named_design("jee-koren-2004-aflc"), target, tmp_path / "x")
    (file,) = (tmp_path / "x").glob("rules.*")
    assert "the adaptation itself is not here" in file.read_text()
    assert "adaptation is not here" in (tmp_path / "x" / "controller.json").read_text()


@pytest.mark.parametrize("target", LANGUAGES)
def test_names_that_would_be_code_are_not_written(target, tmp_path):
    """parse_design refuses such a design; the writers do not rely on it."""
    record = named_design("jee-koren-2004-flc")
    written(record.model_copy(update={"name": EVIL}), target, tmp_path / "x")
    for file in (tmp_path / "x").glob("rules.*"):
        assert "system(" not in file.read_text()
        assert "x_; system__id__" in file.read_text()
    terms = list(record.controller.error_terms)
    terms[0] = terms[0].model_copy(update={"label": EVIL})
    controller = record.controller.model_copy(update={"error_terms": tuple(terms)})
    with pytest.raises(UserError, match="is no identifier"):
        written(record.model_copy(update={"controller": controller}), target, tmp_path / "y")
    assert not (tmp_path / "y").exists()


def test_fll_of_a_gaussian_and_of_the_outermost_triangles(tmp_path):
    """sigma = 1/sqrt(2 rate): 1/sqrt(8) for LL eq. 3a, 1/8 for eq. 3c."""
    text = (
        written(named_design("lin-lee-1999-table-1"), "fll", tmp_path / "x") / "unit_7.fll"
    ).read_text()
    assert "  term: f1 GaussianProduct -1.1 0.35355339059327373 -0.9 0.35355339059327373\n" in text
    assert "  term: f3 GaussianProduct -0.2 0.125 -0.2 0.125\n" in text
    assert (
        "  rule: if previous_spindle_velocity is f1 and spindle_velocity is f2 "
        "then unit_7 is u1_2\n" in text
    )
    assert "  term: u1_2 Constant 0.4644\n" in text
    text = (
        written(named_design("jee-koren-2004-flc"), "fll", tmp_path / "y") / "rules.fll"
    ).read_text()
    assert "  term: NL Ramp -16.0 -21.0\n  term: NM Triangle -19.0 -14.0 -9.0\n" in text
    assert "  term: PL Ramp 16.0 21.0\n" in text


def test_a_dead_zone_stands_beside_the_table(tmp_path):
    design = load_design("jee-koren-2004-flc", {"controller.dead_zone": 1.0})
    FORMATS["fis"].write(design, tmp_path / "out")
    beside = json.loads((tmp_path / "out" / "controller.json").read_text())
    assert beside["dead_zone"] == 1.0
    assert beside["steps"][0] == "an error no larger than dead_zone becomes 0"
    script = (tmp_path / "out" / "controller.m").read_text()
    assert "if abs(signals.error) <= 1.0\n    signals.error = 0.0;\nend\n" in script
