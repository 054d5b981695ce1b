"""What is gathered from the code: all has a meaning, numbers a unit; the data file is new."""

import pytest

from hfc_design.core.records import Positive, Record
from hfc_design.reference.entries import (
    FILE,
    Entry,
    entries,
    unknown,
    written,
)
from hfc_design.schema.collect import collect
from hfc_design.schema.comments import source_in
from hfc_design.schema.fields import fields_of


@pytest.fixture(scope="module")
def every():
    return collect()


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


class Own(Record):
    """A record as users write them."""

    gain: Positive = 2.0  # of the valve [bar/V]
    #: how it is named,
    #: in two lines
    title: str = "valve"
    count: Positive  # F_c [unit]; a remark
    silent: int = 3


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
