"""The Structured Text export, executed by tests/helpers/structured_text.py.

No compiler of IEC 61131-3 is on a registry that is reachable here; tests/interop/test_st.py has two
parsers of others read the files. Measured: 2e-16 of the largest command.
"""

from itertools import product

import made_up
import numpy as np
import pytest
from structured_text import FunctionBlock
from wiring import design, not_adapting, silent, units

from hfc_design.controllers.flc.record import CompensationRecord
from hfc_design.core.records import UserError
from hfc_design.files.design import Design, builtin_designs, named_design
from hfc_design.formats import FORMATS
from hfc_design.formats.fcl import real
from hfc_design.runtime import Controller

LOW = CompensationRecord(
    forward=(0.5, -2.0, 3.0),
    backward=(-0.4, -1.5, -2.5),
    highest_velocity_mm_s=2.0,
    breakaway=(4.0, -5.0),
    smallest_error=1.5,
)


@pytest.fixture
def text(tmp_path):
    def write(design):
        FORMATS["st"].write(design, tmp_path / "design.st")
        return (tmp_path / "design.st").read_text()

    return write


def updated(name, **changes):
    """A built-in design with other keys of its controller."""
    data = named_design(name).model_dump(mode="json")
    data["controller"] |= changes
    return Design.model_validate(data)


CASES = {
    "pd": (named_design("pd-only"),) * 2,
    "pid": (named_design("jee-koren-2004-pid"),) * 2,
    "pid with a dead zone": (updated("jee-koren-2004-pid", dead_zone=2.0),) * 2,
    "flc of 5 x 3": (made_up.named(1, 5, 3),) * 2,
    "flc of 2 x 11": (made_up.named(1, 2, 11),) * 2,
    "flc with a dead zone": (made_up.with_options("flc", 3),) * 2,
    "aflc with a dead zone": (
        updated("jee-koren-2004-aflc", dead_zone=2.0),
        not_adapting(updated("jee-koren-2004-aflc", dead_zone=2.0)),
    ),
    "pid+ff": (made_up.linear("pid+ff", 1),) * 2,
    "lqi within a limit": (made_up.limited(made_up.linear("lqi", 2), 400.0),) * 2,
    "lqr of a feed drive": (made_up.linear("lqr", 3, "feed-drive"),) * 2,
    "table 1": (named_design("lin-lee-1999-table-1"),) * 2,
    "table 2": (named_design("lin-lee-1999-table-2"),) * 2,
    "random": (design("random-1"),) * 2,
    "on a linear part": (made_up.hierarchy_on_linear(4),) * 2,
    "on a linear part within a limit": (made_up.limited(made_up.hierarchy_on_linear(5), 60.0),) * 2,
    "scheduling": (made_up.scheduling(4),) * 2,
    "scheduling within a limit": (made_up.limited(made_up.scheduling(5), 60.0),) * 2,
    "resonators": (made_up.resonating(made_up.linear("lqi", 2), 1, 3.0, 700.0),) * 2,
    "resonators within a limit": (
        made_up.limited(made_up.resonating(made_up.scheduling(5), 2, 3.0, 700.0), 60.0),
    )
    * 2,
    "silent": (silent(),) * 2,
    "aflc": (
        named_design("jee-koren-2004-aflc"),
        not_adapting(named_design("jee-koren-2004-aflc")),
    ),
    "soflc": (
        named_design("jee-koren-1995-soflc"),
        not_adapting(named_design("jee-koren-1995-soflc")),
    ),
}
for form in ("P", "PI", "PD"):
    changes = {"form": form, "integral_gain": 0.7, "low_velocity": LOW.model_dump(mode="json")}
    CASES[form] = (updated("jee-koren-2004-flc", **changes),) * 2
    changes["low_velocity"]["blu_mm"] = 0.02
    CASES[f"{form}, another BLU"] = (updated("jee-koren-2004-flc", **changes),) * 2


WRITTEN = [name for name in builtin_designs() if named_design(name).kind.st]


def samples(record, count=800):
    """Random signals, then all pairs of edges and centres, their outermost and beyond."""
    rng = np.random.default_rng(11)
    inputs = getattr(record.controller, "inputs", ())
    spans = {"error": 30.0} if record.plant.name == "feed-drive" else {"error": 1.0}
    spans |= {"error_rate": 1.0, "velocity": 0.0}
    spans |= {item.name.removeprefix("previous_"): 1.3 / item.scale for item in inputs}
    spans |= {name: 1.0 for name in record.kind.reads(record.controller) if name not in spans}
    signals = {name: span * rng.uniform(-1.0, 1.0, count) for name, span in spans.items()}
    signals["velocity"] = 400.0 * rng.uniform(-1.0, 1.0, count) ** 3
    rows = [
        dict(zip(signals, row, strict=True)) for row in np.array([*signals.values()]).T.tolist()
    ]
    if inputs:
        marks = [-2.0, -1.1, -1.0, -0.6, -0.2, 0.0, 0.05, 0.2, 0.65, 1.0, 1.5]
        names = [item.name for item in inputs if not item.name.startswith("previous_")]
        scales = {item.name: item.scale for item in inputs}
        for left, right in product(marks, repeat=2):
            row = dict.fromkeys(signals, 0.0)
            for k, name in enumerate(names):
                row[name] = (left, right)[k % 2] / scales[name]
            rows.append(row)
    elif spans["error"] == 30.0:
        marks = [-40.0, -21.0, -16.5, -2.0, -0.5, 0.0, 1.5, 4.5, 7.0, 21.0, 40.0]
        rows += [
            dict.fromkeys(signals, 0.0) | {"error": e}
            for pair in product(marks, repeat=2)
            for e in pair
        ]
    return rows


@pytest.mark.parametrize("case", CASES)
def test_the_block_gives_the_commands_of_the_runtime(case, text):
    record, stepped = CASES[case]
    block, controller = FunctionBlock(text(record)), Controller(stepped)
    rows = samples(record)
    found = [block.step(**{n: row[n] for n in block.inputs if n != "reset"}) for row in rows]
    wanted = [controller.step(row) for row in rows]
    assert np.abs(np.subtract(found, wanted)).max() <= 1e-12 * np.abs(wanted).max()


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


def test_reset_forgets_the_past(text):
    block = FunctionBlock(text(CASES["PI"][0]))
    first = block.step(error=5.0, velocity=10.0)
    assert block.step(error=5.0, velocity=10.0) != first
    assert block.step(error=5.0, velocity=10.0, reset=True) == first


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


@pytest.mark.parametrize("name", [*WRITTEN, "adapting hierarchy"])
def test_the_head_says_when_the_adaptation_is_left_out(name, text):
    adapts = name.endswith(("aflc", "soflc", "hierarchy"))
    if name == "adapting hierarchy":
        record = updated("lin-lee-1999-table-1", adaptation={"largest_move": 2.0})
    else:
        record = named_design(name)
    assert ("the adaptation is not here" in text(record)) == adapts


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
    with pytest.raises(UserError, match=f"--to st: .*{fault}"):
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
