"""What is gathered from the code: all has a meaning, numbers a unit; the data file is new."""

import pytest

from hfc_design.gather.gather import gather
from hfc_design.reference.entries import (
    FILE,
    entries,
    written,
)


@pytest.fixture(scope="module")
def every():
    return gather()


def test_the_data_file_is_what_the_code_says(every):
    assert FILE.read_text("utf-8") == written(every), "make reference"
    assert list(entries()) == every
