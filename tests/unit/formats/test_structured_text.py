"""The Structured Text export, alone and in PLCopen's XML, executed by structured_text.py.

tests/interop/test_st.py has two parsers and a compiler of others read the files and run them.
Measured: 2e-16 of the largest command.
"""

import xml.etree.ElementTree as ET

import numpy as np
import pytest
from exported import with_controller
from plcopen_project import PPX, block_in, function_block
from st_cases import updated
from structured_text import FunctionBlock
from wording import refused

from hfc_design.files.design import named_design
from hfc_design.formats.plcopen import project
from hfc_design.formats.st import text_of
from hfc_design.runtime import Controller


def test_the_block_reads_as_it_would_be_written_by_hand():
    lines = text_of(named_design("lin-lee-1999-table-1"))
    assert "FUNCTION_BLOCK fb_lin_lee_1999_table_1\nVAR_INPUT\n    reset : BOOL;\n" in lines
    assert "    error : LREAL; (* rad *)\n" in lines
    assert "    command : LREAL; (* V *)\n" in lines
    assert "    kp : LREAL := 758.405;\n" in lines
    assert "    readings_spindle_velocity : LREAL := 0.0;\n" in lines
    assert "(* Output of one unit from the degrees (7,) of its two inputs (LL eq. 4). *)\n" in lines
    assert "scaled_0 := scales[0] * error;\n" in lines


@pytest.mark.parametrize(
    "name",
    [
        "Retain",
        "a__b",
    ],
)
def test_a_name_that_is_none_of_the_standard_is_refused(name):
    with refused() as found:
        text_of(renamed("deflection", name))
    assert found.where == "to='st'"


def renamed(old, new):
    data = named_design("lin-lee-1999-table-1").model_dump(mode="json")["controller"]
    inputs = [item | {"name": new} if item["name"] == old else item for item in data["inputs"]]
    units = [{k: new if v == old else v for k, v in unit.items()} for unit in data["units"]]
    return updated("lin-lee-1999-table-1", inputs=inputs, units=units)


def test_no_name_gets_code_into_the_file():
    evil = "x *) END_FUNCTION_BLOCK (* y"
    written = text_of(named_design("pd-only").model_copy(update={"name": evil}))
    comment, body = written.split("\n*)\n")
    assert "*)" not in comment
    assert body.count("END_FUNCTION_BLOCK\n") == 1
    assert FunctionBlock(written).block == "fb_x_END_FUNCTION_BLOCK_y"
    good = named_design("lin-lee-1999-table-1")
    first, item, *others = good.controller.inputs
    with refused():
        text_of(
            with_controller(good, inputs=(first, item.model_copy(update={"name": evil}), *others))
        )


def test_a_block_from_the_project_gives_the_commands_of_the_runtime():
    record = named_design("lin-lee-1999-table-1")
    block, controller = (
        FunctionBlock(function_block(*block_in(project(record)))),
        Controller(record),
    )
    rng = np.random.default_rng(3)
    for _ in range(50):
        row = {name: 0.05 * rng.uniform(-1, 1) for name in block.inputs if name != "reset"}
        assert block.step(**row) == pytest.approx(controller.step(row), rel=1e-12)


def test_nothing_that_a_user_wrote_is_markup():
    evil = 'x"><addData/>&amp;<!-- ]]> \x1b'
    record = named_design("pd-only").model_copy(update={"name": evil})
    root = ET.fromstring(project(record))
    assert root.find(f".//{PPX}addData") is None
    assert len(root.findall(f".//{PPX}pou")) == 2
