"""What stands in exported C code, and which designs and options it refuses."""

import re
import subprocess
from dataclasses import replace
from math import exp

import feed_oracle
import made_up
import numpy as np
import pytest
from c_program import built, commands
from click.testing import CliRunner

from hfc_design import api
from hfc_design.cli import main
from hfc_design.controllers.hierarchical.code import lookup
from hfc_design.core.records import UserError
from hfc_design.files.design import builtin_designs, design_json, parse_design
from hfc_design.files.pairing import load_design
from hfc_design.formats import FORMATS, code, machine_code
from hfc_design.runtime import Controller
from plants import C_AXIS

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
    assert "static const real error_centres[ERROR_TERMS] = { R(-21.0), R(-14.0), R(-7.0)," in text
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


@pytest.mark.slow
@pytest.mark.parametrize("name", ["lin-lee-1999-table-2", "jee-koren-1995-soflc", "pd-only"])
def test_the_same_design_gives_the_same_bytes(name, tmp_path):
    for folder in ("a", "b"):
        assert hfc("export", name, "--to", "c", "--out", tmp_path / folder).exit_code == 0
    first, second = (
        {x.relative_to(top): x.read_bytes() for x in top.rglob("*") if x.is_file()}
        for top in (tmp_path / "a", tmp_path / "b")
    )
    assert {path.name for path in first} >= {"check.c", "vectors.csv", "Makefile", "README.md"}
    assert len(first) == 6
    assert first == second


@pytest.mark.slow
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
    assert "a whole number from 2 to 32767" in refused(*fuzzy, "--lookup", 1)
    assert not (tmp_path / "c").exists()


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


def table_of(kind, height, **adaptation):
    design = made_up.fuzzy(kind, 1)
    rules = {"centroids": np.full((7, 7), height).tolist()}
    changes = {"rules": rules}
    if adaptation:
        own = design.controller.adaptation.model_dump()
        changes["adaptation"] = own | {"smallest_overlap": adaptation}
    return made_up.fuzzy(kind, 1, **changes)


@pytest.mark.parametrize("target", ["c", "st"])
@pytest.mark.parametrize(
    ("design", "told"),
    [
        (table_of("flc", 1e154), "centroids.0.0 = 1e+154: code takes numbers up to 1e+100"),
        (table_of("soflc", -1e11), "= -1e+11: code takes numbers up to 1e+09 where it adapts"),
        (("pd-only", {"controller.pd.kp": 1e308}), "controller.pd.kp = 1e+308: code takes"),
        (("pd-only", {"limits.command": 1e200}), "limits.command = 1e+200: code takes"),
    ],
)
def test_what_would_overflow_is_refused(design, told, target, tmp_path):
    design = load_design(*design) if isinstance(design, tuple) else design
    with pytest.raises(UserError, match=re.escape(told)):
        FORMATS[target].write(design, tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("design", "told"),
    [
        (table_of("aflc", 1e8), "go up to 1e+08, adaptation.stable_range holds them to"),
        (table_of("aflc", 9.0, error=1e-300, error_change=0.1), "an overlap is too small"),
    ],
)
def test_an_adaptation_in_which_c_would_differ_is_refused(design, told, tmp_path):
    with pytest.raises(UserError, match=re.escape(told)):
        FORMATS["c"].write(design, tmp_path / "out")


def test_a_table_beyond_its_range_that_is_not_refused_is_equal(tmp_path):
    errors = np.random.default_rng(0).normal(0.0, 15.0, 300)
    design = table_of("aflc", 3e4)
    design = design.model_copy(
        update={"controller": design.controller.model_copy(update={"low_velocity": None})}
    )
    controller = Controller(design)
    expected = [controller.step({"error": error}) for error in errors.tolist()]
    found = commands(built("gcc", design, tmp_path / "c"), errors[:, None])
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-10)


@pytest.mark.parametrize("kind", ["pid", "flc", "aflc", "soflc"])
def test_options_are_in_c_too(kind, tmp_path):
    """Dead zone, ZR that is narrowed, the curve of the stable range: as the runtime to the bit."""
    design = load_design("jee-koren-2004-pid", {"controller.dead_zone": 1.0})
    if kind != "pid":
        design = made_up.with_options(kind, 5)
    names = list(code.signals(design))
    errors = feed_oracle.errors(1500, 4)
    samples = np.stack([errors, 300.0 * np.sin(np.arange(1500) / 70.0)][: len(names)], axis=1)
    controller = Controller(design)
    rows = (dict(zip(names, row, strict=True)) for row in samples.tolist())
    expected = [controller.step(row) for row in rows]
    found = commands(built("gcc", design, tmp_path / "c"), samples)
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("limit", [None, 60.0])
@pytest.mark.parametrize("made", [made_up.linear("lqi", 1), made_up.scheduling(5)])
def test_resonators_are_those_of_the_runtime(made, limit, tmp_path):
    """All other designs are compiled in tests/interop."""
    design = made_up.resonating(made_up.limited(made, limit), 3, 2.0, 50.0, 900.0)
    names = list(code.signals(design))
    samples = np.random.default_rng(0).normal(0.0, 0.1, (500, len(names)))
    controller = Controller(design)
    expected = [controller.step(dict(zip(names, row, strict=True))) for row in samples.tolist()]
    found = commands(built("gcc", design, tmp_path / "c"), samples)
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-11)


NARROW = load_design("jee-koren-2004-flc").model_dump(mode="json")["controller"]["error_terms"]
NARROW[0] |= {"right": -14.0}
NARROW[1] |= {"left": -14.0 - 1e-9}


@pytest.mark.parametrize(
    ("design", "told"),
    [
        (("jee-koren-2004-pid", {"controller.sample_time_s": 1e-320}), "sample_time_s is 9.99"),
        (("jee-koren-2004-pid", {"controller.pid.k_p": 1e38}), "pid.k_p is 1e"),
        (("lin-lee-1999-table-1", {"controller.output_scale": 1e-50}), "output_scale is 1e-50"),
        (("jee-koren-2004-flc", {"controller.error_terms": NARROW}), "a term has no width"),
        (table_of("aflc", 9.0, error=1e-7, error_change=0.1), "a term has no width"),
    ],
)
def test_what_is_nothing_in_float_compiles_in_double_alone(design, told, tmp_path):
    design = load_design(*design) if isinstance(design, tuple) else design
    built("gcc", design, tmp_path / "double")
    with pytest.raises(subprocess.CalledProcessError):
        built("gcc", design, tmp_path / "float", "-DHFC_FLOAT")
    assert re.search(rf'#error "has to be in double: .*{told}', source(design, tmp_path / "c"))


def test_the_built_in_designs_fit_into_float():
    parts = [part for name in builtin_designs() for part in load_design(name).by_axis().values()]
    files = [machine_code.sources(part) for part in parts]
    sources = [text for own in files for file, text in own.items() if file.endswith(".c")]
    assert len(sources) > len(builtin_designs())  # some have several axes
    assert not [text for text in sources if "#error" in text]


@pytest.mark.parametrize("flag", ["-ffast-math", "-Ofast", "-ffinite-math-only"])
def test_a_compiler_that_knows_no_nan_is_stopped(flag, tmp_path):
    design = load_design("jee-koren-2004-flc")
    with pytest.raises(subprocess.CalledProcessError):
        built("gcc", design, tmp_path / "c", flag)
    program = built("gcc", design, tmp_path / "d", flag, "-fno-finite-math-only")
    found = commands(program, np.array([[3.0], [np.nan], [np.inf], [4.0]]))
    assert np.isnan(found).tolist() == [False, True, True, False]
