"""A PLC, of which tests/helpers/st_program.py has the language, runs the vectors of all blocks."""

import re

import pytest
from flash_folders import ALL, page, runs_in_a_plc


@pytest.mark.parametrize("name", [name for name, design in ALL.items() if design.kind.st])
def test_a_plc_runs_all_vectors(name):
    runs_in_a_plc(ALL[name])


def test_axes_that_differ_have_units_of_their_own():
    text = page(ALL["lin-gai-2009-fuzzy-sliding-compensated"])
    row = r"\| x, y, z \| `error` \| in \| mm \| \S+ \| reference less position \|"
    assert re.search(row, text)
    assert "| a, c | `error_rate` | in | deg/s |" in text
    assert text.count("ideal tachometer:") == 1
