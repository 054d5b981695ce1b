"""The Structured Text export, executed by tests/helpers/structured_text.py.

tests/interop/test_st.py has two parsers and a compiler of others read the files and run them.
Measured: 2e-16 of the largest command.
"""

import pytest
from st_cases import CASES, WRITTEN, updated
from structured_text import FunctionBlock

from hfc_design.files.design import named_design
from hfc_design.formats import code


@pytest.fixture
def text(tmp_path):
    def write(design):
        (tmp_path / "design.st").write_text(code.block(design))
        return (tmp_path / "design.st").read_text()

    return write


def test_reset_forgets_the_past(text):
    block = FunctionBlock(text(CASES["PI"][0]))
    first = block.step(error=5.0, velocity=10.0)
    assert block.step(error=5.0, velocity=10.0) != first
    assert block.step(error=5.0, velocity=10.0, reset=True) == first


@pytest.mark.parametrize("name", [*WRITTEN, "adapting hierarchy"])
def test_the_head_says_when_the_adaptation_is_left_out(name, text):
    adapts = name.endswith(("aflc", "soflc", "hierarchy"))
    if name == "adapting hierarchy":
        record = updated("lin-lee-1999-table-1", adaptation={"largest_move": 2.0})
    else:
        record = named_design(name)
    assert ("the adaptation is not here" in text(record)) == adapts
