"""Reset in the Structured Text export, and the block in PLCopen's XML.

tests/interop/test_st.py checks both with programs of others.
"""

import xml.etree.ElementTree as ET

import made_up
import pytest
from plcopen_project import PPX, block_in, function_block, pous
from structured_text import FunctionBlock
from wiring import silent

from hfc_design.files.design import named_design
from hfc_design.formats.plcopen import project
from hfc_design.formats.st import text_of

CASES = {
    "pd": named_design("pd-only"),
    "hierarchy": made_up.hierarchy(1),
    "flc with options": made_up.with_options("flc", 3),
    "lqi within a limit": made_up.limited(made_up.linear("lqi", 2), 400.0),
    "scheduling": made_up.limited(made_up.scheduling(5), 60.0),
    "silent": silent(),
}


@pytest.mark.parametrize("case", CASES)
def test_the_block_of_a_project_is_that_of_structured_text(case):
    record = CASES[case]
    name, sections, body = block_in(project(record))
    written = text_of(record)
    here, there = FunctionBlock(function_block(name, sections, body)), FunctionBlock(written)
    assert (here.block, here.values, here.kinds) == (there.block, there.values, there.kinds)
    assert here.inputs == there.inputs
    assert body in written
    assert body.endswith("fault := FALSE;\n")


def test_a_task_calls_the_block_once_a_sample():
    record = made_up.linear("lqr", 3, "feed-drive")
    every = record.controller.model_copy(update={"sample_time_s": 0.0025})
    text = project(record.model_copy(update={"controller": every}))
    task = ET.fromstring(text).find(f".//{PPX}task")
    assert task.get("interval") == "T#2.5ms"
    program = task.find(f"{PPX}pouInstance").get("typeName")
    kind, sections, body = pous(text)[program]
    name, block = sections["localVars"][0][:2]
    assert (kind, pous(text)[block][0]) == ("program", "functionBlock")
    assert body.startswith(f"{name}(reset := FALSE, error := error, ")
    given = {item.split(" := ")[0] for item in body.partition(")")[0].split("(")[1].split(", ")}
    assert given == {one[0] for one in pous(text)[block][1]["inputVars"]}
    assert given - {"reset"} < {one[0] for one in sections["localVars"]}
    assert body.endswith(f"command := {name}.command;\nfault := {name}.fault;\n")
