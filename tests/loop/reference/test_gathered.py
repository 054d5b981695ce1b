"""What is gathered from the code: all has a meaning, numbers a unit; the data file is new."""

from typing import NamedTuple

import pytest

from hfc_design.core.records import Positive, Record
from hfc_design.files.named_scenario import load_scenario
from hfc_design.gather.comments import comments_of, said, source_in
from hfc_design.gather.fields import fields_of
from hfc_design.gather.gather import gather
from hfc_design.reference.entries import (
    FILE,
    KEY,
    PLANT,
    SCENARIO,
    Entry,
    entries,
    things,
    unknown,
    written,
)


@pytest.fixture(scope="module")
def every():
    return gather()


def test_everything_has_a_meaning_and_every_number_a_unit(every):
    without = [f"{one.kind} {one.name} {one.key}" for one in every if not one.meaning]
    assert without == []
    numbers = [one for one in every if "number" in one.type.replace("whole number", "")]
    assert len(numbers) > 500
    assert [f"{one.kind} {one.name} {one.key}" for one in numbers if not one.unit] == []


def test_the_data_file_is_what_the_code_says(every):
    assert FILE.read_text("utf-8") == written(every), "make reference"
    assert list(entries()) == every


def test_no_key_stands_there_twice(every):
    keys = [(one.kind, one.name, one.part, one.key) for one in every]
    assert len(set(keys)) == len(keys)


def test_a_parameter_as_the_paper_prints_it(every):
    """Lin & Lee 1999, section 4."""
    (own,) = [one for one in every if one.key == "plant.parameters.spindle_inertia"]
    assert own[:7] == ("plant", "c-axis", "parameter", own.key, "number", "kg m2", 5.102)
    assert own.allowed == "greater than 0"
    (plant,) = [one for one in things(PLANT) if one.name == "c-axis"]
    assert plant.source == "Lin & Lee 1999, eq. 1-2"


def test_defaults_are_those_of_a_scenario_that_says_nothing():
    whole = load_scenario({"name": "nothing"}).model_dump(mode="json")
    compared = 0
    for one in things(KEY):
        place = whole
        for part in one.key.split("."):
            place = place.get(part) if isinstance(place, dict) else None
        if isinstance(place, float | int | str) and one.key != "name":
            assert one.default == place, one.key
            compared += 1
    assert compared >= 15


class Own(Record):
    """A record as users write them."""

    gain: Positive = 2.0  # of the valve [bar/V]
    #: how it is named,
    #: in two lines
    title: str = "valve"
    count: Positive  # F_c [unit]; a remark
    silent: int = 3


class Made(NamedTuple):
    mass: float = 1.0  # of all [kg]


def test_comments_behind_and_before_a_field():
    found = comments_of(Own)
    assert found["gain"] == ("of the valve", "bar/V")
    assert found["title"] == ("how it is named, in two lines", "")
    assert found["count"] == ("F_c; a remark", "unit")
    assert "silent" not in found
    assert comments_of(Made) == {"mass": ("of all", "kg")}


def test_brackets_that_are_no_unit():
    assert said("[low, high] of gains that are searched [1/s]") == (
        "[low, high] of gains that are searched",
        "1/s",
    )
    assert said("left out: [load] of the scenario") == ("left out: [load] of the scenario", "")


def test_fields_of_a_record():
    gain, title, count, silent = fields_of(Own, "own.", Entry("key", "own"))
    assert (gain.key, gain.type, gain.default, gain.allowed) == (
        "own.gain",
        "number",
        2.0,
        "greater than 0",
    )
    assert (title.type, title.default) == ("text", "valve")
    assert count.required
    assert not gain.required
    assert (silent.type, silent.default) == ("whole number", 3)


@pytest.mark.parametrize(
    ("text", "source"),
    [
        ("(Lin & Lee 1999, cited as LL, eq. 1-2)", "Lin & Lee 1999, eq. 1-2"),
        ("k = F + eta of LG09 eq. 11, F a constant", "Lin & Gai 2009, eq. 11"),
        ("as JK95 says.", "Jee & Koren 1995"),
        ("of the motor, LLx", ""),
    ],
)
def test_sources(text, source):
    assert source_in(text) == source


def test_unknown_names_tell_what_is_near():
    told = str(unknown("plant", "c-axsi", ["c-axis", "feed-drive"]))
    assert told == "'c-axsi': unknown plant; did you mean c-axis? available: c-axis, feed-drive"


def test_every_built_in_scenario_has_a_line():
    assert all(one.meaning for one in things(SCENARIO))
