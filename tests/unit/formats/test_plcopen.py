"""The project of PLCopen's XML holds the function block of ``--to st``, and a task that calls it.

tests/interop/test_st.py checks it against the published schema and has others read it.
"""

import json
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from plcopen_project import PPX, block_in, function_block
from structured_text import FunctionBlock
from wording import refused

from hfc_design.files.design import Design, design_json, named_design
from hfc_design.formats.plcopen import project
from hfc_design.runtime import Controller


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


def test_every_signal_says_what_it_is_and_in_which_unit():
    _, sections, _ = block_in(project(named_design("lin-lee-1999-table-1")))
    told = {name: text for name, _, _, text in sections["inputVars"] + sections["outputVars"]}
    assert told["error"] == "reference less position, [rad]"
    assert told["spindle_velocity"].endswith("[rad/s]")
    assert told["command"].endswith("[V]")
    assert all(told.values())


def test_nothing_that_a_user_wrote_is_markup():
    evil = 'x"><addData/>&amp;<!-- ]]> \x1b'
    record = named_design("pd-only").model_copy(update={"name": evil})
    root = ET.fromstring(project(record))
    assert root.find(f".//{PPX}addData") is None
    assert len(root.findall(f".//{PPX}pou")) == 2


def test_a_kind_without_structured_text_is_refused():
    with refused():
        project(named_design("huang-neural"))


def test_a_name_that_the_example_takes_is_refused():
    text = design_json(named_design("lin-lee-1999-table-1"))
    taken = text.replace('"deflection"', '"fb_lin_lee_1999_table_1_1"')
    with refused():
        project(Design.model_validate(json.loads(taken)))
