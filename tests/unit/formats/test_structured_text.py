"""The Structured Text export, executed by tests/helpers/structured_text.py.

tests/interop/test_st.py has two parsers and a compiler of others read the files and run them.
Measured: 2e-16 of the largest command.
"""

import pytest
from st_cases import samples, updated
from structured_text import FunctionBlock
from wiring import design, units

from hfc_design.core.records import UserError
from hfc_design.files.design import named_design
from hfc_design.formats import code
from hfc_design.formats.fcl import real


@pytest.fixture
def text(tmp_path):
    def write(design):
        (tmp_path / "design.st").write_text(code.block(design))
        return (tmp_path / "design.st").read_text()

    return write


def test_every_unit_is_the_weighted_average_of_its_rules(text):
    record = design("random-2")
    block = FunctionBlock(text(record))

    def value(name):
        return block.values[name if name.startswith("unit_") else f"scaled_{name}"]

    for row in samples(record, 400):
        block.step(**{name: row[name] for name in block.inputs if name != "reset"})
        for unit in units(record):
            expected = unit.expected(value(unit.row), value(unit.column))
            assert abs(value(unit.name) - expected) <= 1e-12


def test_the_block_reads_as_it_would_be_written_by_hand(text):
    lines = text(named_design("lin-lee-1999-table-1"))
    assert "FUNCTION_BLOCK fb_lin_lee_1999_table_1\nVAR_INPUT\n    reset : BOOL;\n" in lines
    assert "    error : LREAL; (* rad *)\n" in lines
    assert "    command : LREAL; (* V *)\n" in lines
    assert "    kp : LREAL := 758.405;\n" in lines
    assert "        0.1, 0.05, 0.0, 0.0, 0.0, 0.05, 0.1\n" in lines
    assert "    previous_spindle_velocity : LREAL := 0.0;\n" in lines
    assert "command := kp * error + kd * error_rate + output_scale * unit_0;\n" in lines


@pytest.mark.parametrize(
    ("value", "literal"), [(1.0, "1.0"), (-2.5e-7, "-2.5E-7"), (1e-05, "1.0E-5"), (1e22, "1.0E22")]
)
def test_a_literal_has_a_point(value, literal):
    assert real(value) == literal


def test_the_same_design_gives_the_same_bytes(text):
    assert text(named_design("lin-lee-1999-table-2")) == text(named_design("lin-lee-1999-table-2"))


@pytest.mark.parametrize(
    ("name", "fault"),
    [
        ("Retain", "takes Retain for a word of the language"),
        ("unit_7", "takes unit_7 for unit_7"),
        ("Distance", "takes distance for Distance"),
        ("a__b", "is no identifier"),
        ("a_", "is no identifier"),
        ("_a", "is no identifier"),
    ],
)
def test_a_name_that_is_none_of_the_standard_is_refused(name, fault, text):
    with pytest.raises(UserError, match=f"to='st': .*{fault}"):
        text(renamed("deflection", name))


def renamed(old, new):
    data = named_design("lin-lee-1999-table-1").model_dump(mode="json")["controller"]
    inputs = [item | {"name": new} if item["name"] == old else item for item in data["inputs"]]
    units = [{k: new if v == old else v for k, v in unit.items()} for unit in data["units"]]
    return updated("lin-lee-1999-table-1", inputs=inputs, units=units)


def test_no_name_gets_code_into_the_file(text):
    evil = "x *) END_FUNCTION_BLOCK (* y"
    written = text(named_design("pd-only").model_copy(update={"name": evil}))
    comment, code = written.split("\n*)\n")
    assert "*)" not in comment
    assert code.count("END_FUNCTION_BLOCK\n") == 1
    assert FunctionBlock(written).block == "fb_x_END_FUNCTION_BLOCK_y"
    good = named_design("lin-lee-1999-table-1")
    item = good.controller.inputs[1].model_copy(update={"name": evil})
    inputs = (good.controller.inputs[0], item, *good.controller.inputs[2:])
    controller = good.controller.model_copy(update={"inputs": inputs})
    with pytest.raises(UserError, match="is no identifier"):
        text(good.model_copy(update={"controller": controller}))
