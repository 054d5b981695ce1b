"""The page on a design names what to connect, how it was measured, and what it does."""

import re

import pytest
from flash_folders import ALL, FEW, written

from hfc_design.formats import code, machine_code
from hfc_design.formats.flash.folder import with_check


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return written(tmp_path_factory.mktemp)


@pytest.mark.parametrize("name", FEW)
def test_the_page_names_every_input_with_its_unit(name, folder):
    text = (folder(name) / "README.md").read_text()
    for signal, unit in code.signals(ALL[name]).items():
        assert unit
        assert re.search(rf"\| `{signal}` \| in \| {re.escape(unit)} \| \S+ \| \w", text), signal
    assert re.search(r"\| `command` \| out \| \w+ \| \S+ \| \w", text)


def test_axes_that_differ_have_units_of_their_own():
    record = ALL["lin-gai-2009-fuzzy-sliding-compensated"]
    text = with_check(record, machine_code.sources(record))["README.md"]
    assert re.search(
        r"\| x, y, z \| `error` \| in \| mm \| \S+ \| reference less position \|", text
    )
    assert "| a, c | `error_rate` | in | deg/s |" in text
    assert text.count("ideal tachometer:") == 1
