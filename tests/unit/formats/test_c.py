"""What stands in exported C code, and which designs and options it refuses."""

from dataclasses import replace
from math import exp

import pytest
from click.testing import CliRunner

from hfc_design import api
from hfc_design.cli import main
from hfc_design.controllers.hierarchical.code import lookup
from hfc_design.core.records import UserError
from hfc_design.files.design import design_json, parse_design
from hfc_design.files.pairing import load_design
from hfc_design.formats import FORMATS
from plants import C_AXIS

HOSTILE = 'x); system("id */ int main(void) {\n#define x'


def hfc(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def test_the_header_says_what_each_signal_is(tmp_path):
    FORMATS["c"].write(load_design("lin-lee-1999-table-1"), tmp_path / "c")
    header = " ".join((tmp_path / "c" / "lin_lee_1999_table_1.h").read_text().split())
    for told in (
        "* error: reference less position *",
        "* deflection: of the transmission: rotor angle less gear_ratio times spindle angle *",
        "* It is: quadrature stator voltage, positive turns the rotor forwards.",
        "_real deflection; /* [rad] */",
    ):
        assert told in header
    assert "current:" not in header  # it does not read it


def test_what_a_drive_says_of_its_signals_ends_no_comment(tmp_path, own_plugins):
    design = load_design("lin-lee-1999-table-1")
    api.register(replace(C_AXIS, name="spiteful", meanings={"deflection": HOSTILE}))
    plant = design.plant.model_copy(update={"name": "spiteful"})
    FORMATS["c"].write(design.model_copy(update={"plant": plant}), tmp_path / "c")
    header = next((tmp_path / "c").glob("*.h")).read_text()
    assert "system(" not in header
    assert "#define x" not in header


@pytest.mark.parametrize("name", ["double", "previous_while", "__LINE__"])
def test_an_input_named_like_a_word_of_c_is_refused(name, tmp_path):
    text = design_json(load_design("lin-lee-1999-table-1")).replace('"deflection"', f'"{name}"')
    design = parse_design(text, "mine.json")
    with pytest.raises(UserError, match=f"input named {name.removeprefix('previous_')}"):
        FORMATS["c"].write(design, tmp_path / "c")


def test_lookup_prints_its_error_and_needs_no_library(tmp_path):
    design = load_design("lin-lee-1999-table-1")
    arguments = ("export", design.name, "--to", "c", "--lookup", 65, "--out", tmp_path / "c")
    deviation = lookup(design.controller, 65).deviation
    done = hfc(*arguments)
    assert f"largest deviation from the exact command: {deviation:.2g} V" in done.output
    assert done.stderr == ""
    text = (tmp_path / "c" / "lin_lee_1999_table_1.c").read_text()
    assert "#include <" not in text
    assert f"{deviation:.2g} V" in " ".join(text.split())


def test_lookup_by_hand():
    """33 points from -1 to 1: 0.5 is a point of its own, and exp(-32 0.3^2) stands there."""
    found = lookup(load_design("lin-lee-1999-table-1").controller, 33)
    assert (found.low, found.high, found.per_unit) == (-1.0, 1.0, 16.0)
    expected = [exp(-4 * 1.4**2), exp(-8 * 1.05**2), exp(-32 * 0.7**2), exp(-32 * 0.5**2)]
    expected += [exp(-32 * 0.3**2), exp(-8 * 0.05**2), exp(-4 * 0.4**2)]
    assert found.table[24] == pytest.approx(expected, abs=1e-15)


NARROW = load_design("jee-koren-2004-flc").model_dump(mode="json")["controller"]["error_terms"]
NARROW[0] |= {"right": -14.0}
NARROW[1] |= {"left": -14.0 - 1e-9}
