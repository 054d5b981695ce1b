"""FLL, FCL and FML of what counts in a feed drive's units; a whole controller from the files."""

import json
from functools import partial

import made_up
import numpy as np
import pytest
from exported import texts, with_controller
from fml_oracle import System, read
from wiring import command, controller_error, random_signals
from wording import refused

from hfc_design.files.design import named_design
from hfc_design.files.loop_setup import load_design
from hfc_design.formats import FORMATS

LANGUAGES = ["fll", "fcl", "fcl-jfuzzylogic", "fml"]
EVIL = 'x); system("id") *)\n-->'


LOW_VELOCITY = {
    "forward": [1.5, -2.0, 7.0],
    "backward": [-1.0, 0.5, -7.0],
    "highest_velocity_mm_s": 3.0,
    "breakaway": [8.0, -9.0],
    "smallest_error": 1.0,
}
FORMS = [(form, blu) for form in ("P", "PI", "PD") for blu in ({}, {"blu_mm": 0.004})]


@pytest.mark.parametrize("limit", [None, 12.0])
@pytest.mark.parametrize(("form", "blu"), [*FORMS, ("table 1", {})])
def test_the_files_alone_give_the_command_of_every_form_and_keep_its_limit(
    form, blu, limit, tmp_path
):
    if form == "table 1":
        record = load_design("lin-lee-1999-table-1")
    else:
        low = {"controller.low_velocity": LOW_VELOCITY | blu}
        own = {"controller.form": form, "controller.integral_gain": 4.0 if limit else 2.5}
        record = load_design("jee-koren-2004-flc", own | low)
    record = made_up.limited(record, limit) if limit else record
    FORMATS["fml"].write(record, tmp_path / "x")
    assert controller_error(record, tmp_path / "x", partial(read, System)) <= 1e-12
    if form != "table 1":
        rules = (tmp_path / "x" / "rules.fml").read_text()
        assert ("the change of the command" in rules) == (form == "PI")
    about = json.loads((tmp_path / "x" / "controller.json").read_text())
    assert about.get("largest_command", 0.0) == (limit or 0.0)


@pytest.mark.parametrize("name", ["lin-lee-1999-table-1", "jee-koren-2004-flc"])
def test_the_files_alone_keep_the_rate_of_a_design(name, tmp_path):
    limits = {"command": 12.0, "command_rate": 2.0 / named_design(name).controller.sample_time_s}
    record = load_design(name, {"limits": limits})
    folder = tmp_path / "x"
    FORMATS["fll"].write(record, folder)
    about = json.loads((folder / "controller.json").read_text())
    assert about["largest_change"] == 2.0
    found = command(folder, random_signals(record, 100), lambda *_: np.full(100, 1e9))
    assert [*found[:6]] == [2.0, 4.0, 6.0, 8.0, 10.0, 12.0]


@pytest.mark.parametrize("target", LANGUAGES)
def test_an_adaptive_controller_says_that_its_table_is_a_start(target):
    found = texts(named_design("jee-koren-2004-aflc"), target)
    (rules,) = (text for name, text in found.items() if name.startswith("rules."))
    assert "the adaptation itself is not included" in rules
    assert "state.singletons" in found["controller.m"]


@pytest.mark.parametrize("target", LANGUAGES)
def test_names_that_would_be_code_are_not_written(target):
    """parse_design refuses such a design; the writers do not rely on it."""
    record = named_design("jee-koren-2004-flc")
    found = texts(record.model_copy(update={"name": EVIL}), target)
    (rules,) = (text for name, text in found.items() if name.startswith("rules."))
    assert "system(" not in rules
    assert "x_; system__id__" in rules
    first, *others = record.controller.error_terms
    terms = (first.model_copy(update={"label": EVIL}), *others)
    with refused():
        texts(with_controller(record, error_terms=terms), target)


def test_a_dead_zone_stands_beside_the_table():
    found = texts(load_design("jee-koren-2004-flc", {"controller.dead_zone": 1.0}), "fis")
    beside = json.loads(found["controller.json"])
    assert beside["dead_zone"] == 1.0
    assert "\ndead_zone = 1.0;\n" in found["controller.m"]


@pytest.mark.parametrize(("blu", "factor"), [({}, "0.01"), ({"blu_mm": 0.004}, "0.004")])
def test_the_compensation_counts_in_mm(blu, factor):
    changes = {"controller.low_velocity": made_up.LOW_VELOCITY | blu}
    files = texts(load_design("jee-koren-2004-flc", changes), "fis")
    assert f"\nblu_mm = {factor};\n" in files["controller.m"]
    assert ('"blu_mm"' in files["controller.json"]) == bool(blu)
