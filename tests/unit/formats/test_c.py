"""What stands in exported C code, and which inputs it refuses."""

from dataclasses import replace
from math import exp

import pytest
from exported import texts
from wording import refused

from hfc_design import api
from hfc_design.controllers.hierarchical.code import lookup
from hfc_design.files.design import design_json, parse_design
from hfc_design.files.loop_setup import load_design
from hfc_design.formats import code
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


def test_the_numbers_are_those_of_the_design():
    text = code.sources(TABLE_1)["lin_lee_1999_table_1.c"]
    assert "scales[5] = {\n    R(50.0), R(80.0), R(20.0), R(20.0), R(10.0),\n};" in text
    assert "scales[3] * inputs->spindle_velocity;" in text
    assert "state->readings_spindle_velocity" in text
    assert "R(0.4479), R(0.4644), R(0.5193), R(0.4429)," in text  # LL Table I


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


def test_what_does_not_learn_saves_nothing():
    for design in (TABLE_1, load_design("pd-only")):
        assert not any("_save(" in text for text in code.sources(design).values())


def test_lookup_by_hand():
    """33 points from -1 to 1: 0.5 is a point of its own, and exp(-32 0.3^2) stands there."""
    found = lookup(TABLE_1.controller, 33)
    assert (found.low, found.high, found.per_unit) == (-1.0, 1.0, 16.0)
    expected = [exp(-4 * 1.4**2), exp(-8 * 1.05**2), exp(-32 * 0.7**2), exp(-32 * 0.5**2)]
    expected += [exp(-32 * 0.3**2), exp(-8 * 0.05**2), exp(-4 * 0.4**2)]
    assert found.table[24] == pytest.approx(expected, abs=1e-15)
