"""What stands in exported C code, and which designs and options it refuses."""

import re

import made_up
import numpy as np
import pytest
from click.testing import CliRunner

from hfc_design.cli import main
from hfc_design.core.records import UserError
from hfc_design.files.design import builtin_designs
from hfc_design.files.pairing import load_design
from hfc_design.formats import FORMATS, code, machine_code


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


def test_lookup_needs_c_and_exponentials(tmp_path):
    csv = refused("export", "lin-lee-1999-table-1", "--to", "csv", "--lookup", 9)
    assert "only --to c" in csv
    fuzzy = ("export", "jee-koren-2004-aflc", "--to", "c", "--out", tmp_path / "c")
    assert "kind aflc: nothing to tabulate" in refused(*fuzzy, "--lookup", 9)
    assert "a whole number from 2 to 32767" in refused(*fuzzy, "--lookup", 1)
    assert not (tmp_path / "c").exists()


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


NARROW = load_design("jee-koren-2004-flc").model_dump(mode="json")["controller"]["error_terms"]
NARROW[0] |= {"right": -14.0}
NARROW[1] |= {"left": -14.0 - 1e-9}


def test_the_built_in_designs_fit_into_float():
    parts = [part for name in builtin_designs() for part in load_design(name).by_axis().values()]
    files = [machine_code.sources(part) for part in parts]
    sources = [text for own in files for file, text in own.items() if file.endswith(".c")]
    assert len(sources) > len(builtin_designs())  # some have several axes
    assert not [text for text in sources if "#error" in text]
