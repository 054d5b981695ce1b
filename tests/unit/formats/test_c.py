"""What stands in exported C code, and which inputs it refuses."""

import re
from dataclasses import replace
from functools import cache
from math import exp

import numpy as np
import pytest
from deployment_folders import vectors
from exported import texts
from sledge import hfc
from wording import refused

from hfc_design import api
from hfc_design.controllers.hierarchical.code import tabulated
from hfc_design.files.design import design_json, parse_design
from hfc_design.files.loop_setup import load_design
from hfc_design.formats import code
from hfc_design.runtime import Controller
from plants import C_AXIS

HOSTILE = 'x); system("id */ int main(void) {\n#define x'
TABLE_1 = load_design("lin-lee-1999-table-1")


def test_the_header_says_what_each_signal_is():
    header = " ".join(code.sources(TABLE_1)["lin_lee_1999_table_1.h"].split())
    for told in (
        "* error: reference less position *",
        "* deflection: of the transmission: rotor angle less gear_ratio times spindle angle *",
        "* It is: quadrature stator voltage, positive turns the rotor forwards.",
        "_real deflection; /* [rad] */",
    ):
        assert told in header
    assert "current:" not in header  # it does not read it


def test_no_code_comes_with_a_name_or_what_a_drive_says_of_its_signals(own_plugins):
    told = {"deflection": HOSTILE.replace("\n", " ")}  # a line, or it is refused
    api.register(replace(C_AXIS, name="spiteful", meanings=told))
    for plant in ("spiteful", HOSTILE):
        own = TABLE_1.plant.model_copy(update={"name": plant})
        design = TABLE_1.model_copy(update={"name": HOSTILE, "plant": own})
        for text in code.sources(design).values():
            assert "system(" not in text.replace("(_id", "")
            assert "#define x" not in text
        assert text.index("*/") > text.index("stepped every")  # the head ends where it should
    assert code.c_name(TABLE_1.model_copy(update={"name": "2-axes"})) == "hfc_2_axes"


@pytest.mark.parametrize("name", ["double", "previous_while", "__LINE__"])
def test_an_input_named_like_a_word_of_c_is_refused(name):
    design = parse_design(design_json(TABLE_1).replace('"deflection"', f'"{name}"'), "mine.json")
    with refused():
        texts(design, "c")


def test_lookup_by_hand():
    """33 points from -1 to 1: 0.5 is a point of its own, and exp(-32 0.3^2) stands there."""
    found = tabulated(TABLE_1.controller, 33)["law"].args[0].grid
    assert (found.low, found.per_unit, len(found.table)) == (-1.0, 16.0, 33)
    expected = [exp(-4 * 1.4**2), exp(-8 * 1.05**2), exp(-32 * 0.7**2), exp(-32 * 0.5**2)]
    expected += [exp(-32 * 0.3**2), exp(-8 * 0.05**2), exp(-4 * 0.4**2)]
    assert found.table[24] == pytest.approx(expected, abs=1e-15)


NAME = "lin-lee-1999-table-1"


def off_on_the_vectors(folder, design):
    """Largest difference of the commands there from the design's own, and the largest of those."""
    names, numbers, _ = vectors(folder)
    controller = Controller(design)
    own = []
    for row in numbers:
        if row[0]:
            controller.reset()
        own.append(controller.step(dict(zip(names[2:-1], row[2:-1].tolist(), strict=True))))
    return np.abs(np.array(own) - numbers[:, -1]).max(), np.abs(numbers[:, -1]).max()


@cache
def rules_alone(design):
    """The largest command of a design without gains, for anything within its ranges."""
    bare = load_design(design, {"controller.pd": {"kp": 0.0, "kd": 0.0}})
    random = np.random.default_rng(3)
    controller, found = Controller(bare), 0.0
    reach = {item.name: 1.0 / item.scale for item in bare.controller.inputs}
    for _ in range(3000):
        told = {name: float(size * random.uniform(-1, 1)) for name, size in reach.items()}
        controller.remember({"spindle_velocity": told["previous_spindle_velocity"]})
        found = max(found, abs(controller.step(told | {"error_rate": 0.0})))
    return found


AXES = {"plant.axes.a": "{}", "plant.axes.b": "{}", "limits.axes.b.command": 5.0}


def test_the_command_line_says_how_far_a_table_is_off(tmp_path):
    told = [word for key, x in AXES.items() for word in ("--change", f"{key}={x}")]
    told += ["--to", "c", "--bare", "--lookup", 9, "--out", tmp_path / "c"]
    done = hfc("export", NAME, *told)
    assert done.exit_code == 0, done.output
    assert done.stderr.startswith("hfc: warning: --lookup 9 is coarse")
    lines = iter(done.stdout.splitlines())
    deviation = tabulated(load_design(NAME).controller, 9)["deviation"]
    for axis, limit in {"a": None, "b": 5.0}.items():
        folder = tmp_path / "c" / axis
        of, off_by = next(lines), next(lines)
        far, share = re.findall(r"exact command: (\S+) V, (\S+) % of", of)[0]
        assert far == f"{deviation:.2g}"
        assert float(share) == pytest.approx(100.0 * float(far) / rules_alone(NAME), rel=0.1)
        off, largest = off_on_the_vectors(
            folder, load_design(NAME, {"limits.command": limit} if limit else None)
        )
        assert (largest == limit) if limit else largest > 5.0
        told, share = re.findall(r"off by (\S+) V at most, (\S+) % of", off_by)[0]
        assert float(told) == pytest.approx(off, rel=0.05)  # two digits are printed
        assert float(share) == pytest.approx(100.0 * off / largest, rel=0.05)
        page, (source,) = (folder / "README.md").read_text(), folder.glob("*.c")
        assert "tabulated at 9 values" in vectors(folder)[2]
        assert of.removeprefix(f"{axis}: ") in page
        assert off_by.removeprefix(f"{axis}: ") in page
        assert "#include <math" not in source.read_text()
        assert f"{far} V" in " ".join(source.read_text().split())
