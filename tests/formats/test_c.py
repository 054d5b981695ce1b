"""What stands in exported C code, and which designs and options it refuses."""

import re
from math import exp

import pytest
from click.testing import CliRunner

from hfc_design.cli import main
from hfc_design.controllers.hierarchical.code import lookup
from hfc_design.core.records import UserError
from hfc_design.files.design import design_json, parse_design
from hfc_design.files.pairing import load_design
from hfc_design.formats import FORMATS, code

HOSTILE = 'x); system("id */ int main(void) {\n#define x'


def hfc(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def refused(*arguments):
    found = hfc(*arguments)
    assert found.exit_code == 2
    return found.output


def source(design, folder):
    FORMATS["c"].write(design, folder)
    return (folder / f"{code.c_name(design)}.c").read_text()


def test_the_numbers_are_those_of_the_design(tmp_path):
    text = source(load_design("jee-koren-2004-flc"), tmp_path / "c")
    assert "static const real error_centres[TERMS] = { R(-21.0), R(-14.0), R(-7.0)," in text
    assert "    { R(-16.0), R(-19.0) },\n    { R(-9.0), R(-12.0) },\n" in text  # JK04 Table 3
    assert "{ R(0.0), R(8.0), R(8.0), R(8.0), R(16.0), R(16.0), R(32.0) },\n" in text
    text = source(load_design("lin-lee-1999-table-1"), tmp_path / "d")
    assert "values[3] = clamped(R(20.0) * inputs->spindle_velocity, 1);" in text
    assert "values[4] = clamped(R(10.0) * state->previous_spindle_velocity, 1);" in text
    assert "R(0.4479), R(0.4644), R(0.5193), R(0.4429)," in text  # LL Table I


def test_the_head_says_what_it_is(tmp_path):
    FORMATS["c"].write(load_design("jee-koren-2004-aflc"), tmp_path / "c")
    header = (tmp_path / "c" / "jee_koren_2004_aflc.h").read_text()
    assert re.search(r"design jee-koren-2004-aflc, sha256 [0-9a-f]{64}\n", header)
    assert "_real error; /* [BLU] */" in header
    assert "every 0.01 s" in header


@pytest.mark.parametrize("name", ["lin-lee-1999-table-2", "jee-koren-1995-soflc", "pd-only"])
def test_the_same_design_gives_the_same_bytes(name, tmp_path):
    for folder in ("a", "b"):
        assert hfc("export", name, "--to", "c", "--out", tmp_path / folder).exit_code == 0
    first, second = (sorted((tmp_path / folder).iterdir()) for folder in ("a", "b"))
    assert [path.suffix for path in first] == [".c", ".h"]
    assert [path.read_bytes() for path in first] == [path.read_bytes() for path in second]


def test_no_code_comes_with_a_name(tmp_path):
    design = load_design("jee-koren-2004-aflc")
    plant = design.plant.model_copy(update={"name": HOSTILE})
    design = design.model_copy(update={"name": HOSTILE, "plant": plant})
    text = source(design, tmp_path / "c")
    assert "system(" not in text.replace("(_id", "")
    assert "#define x" not in text
    assert text.index("*/") > text.index("stepped every")  # the head ends where it should
    assert code.c_name(design.model_copy(update={"name": "2-axes"})) == "hfc_2_axes"


@pytest.mark.parametrize("name", ["double", "previous_while", "__LINE__"])
def test_an_input_named_like_a_word_of_c_is_refused(name, tmp_path):
    text = design_json(load_design("lin-lee-1999-table-1")).replace('"deflection"', f'"{name}"')
    design = parse_design(text, "mine.json")
    with pytest.raises(UserError, match=f"input named {name.removeprefix('previous_')}"):
        FORMATS["c"].write(design, tmp_path / "c")


def test_lookup_needs_c_and_exponentials(tmp_path):
    csv = refused("export", "lin-lee-1999-table-1", "--to", "csv", "--lookup", 9)
    assert "only --to c" in csv
    fuzzy = ("export", "jee-koren-2004-aflc", "--to", "c", "--out", tmp_path / "c")
    assert "kind aflc: nothing to tabulate" in refused(*fuzzy, "--lookup", 9)
    assert "2<=x<=32767" in refused(*fuzzy, "--lookup", 1)
    assert not (tmp_path / "c").exists()


def test_lookup_prints_its_error_and_needs_no_library(tmp_path):
    design = load_design("lin-lee-1999-table-1")
    arguments = ("export", design.name, "--to", "c", "--lookup", 65, "--out", tmp_path / "c")
    deviation = lookup(design.controller, 65).deviation
    assert f"largest deviation from the exact command: {deviation:.2g} V" in hfc(*arguments).output
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
