"""C code that a compiler has to refuse, and what only the C of a design does; see ../test_c.py."""

import re
import subprocess

import made_up
import numpy as np
import pytest
from c_program import built, commands
from exported import with_controller

from hfc_design.files.loop_setup import load_design
from hfc_design.formats import code
from hfc_design.runtime import Controller


def test_a_table_beyond_its_range_that_is_not_refused_is_equal(tmp_path):
    errors = np.random.default_rng(0).normal(0.0, 15.0, 300)
    design = with_controller(made_up.level("aflc", 3e4), low_velocity=None)
    controller = Controller(design)
    expected = [controller.step({"error": error}) for error in errors.tolist()]
    found = commands(built("gcc", design, tmp_path / "c"), errors[:, None])
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-10)


NARROW = load_design("jee-koren-2004-flc").model_dump(mode="json")["controller"]["error_terms"]
NARROW[0] |= {"right": -14.0}
NARROW[1] |= {"left": -14.0 - 1e-9}


@pytest.mark.parametrize(
    ("design", "told"),
    [
        (("jee-koren-2004-pid", {"controller.sample_time_s": 1e-320}), "sample_time_s is 9.99"),
        (("lin-lee-1999-table-1", {"controller.output_scale": 1e-50}), "output_scale is 1e-50"),
        (made_up.level("aflc", 9.0, error=1e-7, error_change=0.1), "a term has no width"),
    ],
)
def test_what_is_nothing_in_float_compiles_in_double_alone(design, told, tmp_path):
    design = load_design(*design) if isinstance(design, tuple) else design
    built("gcc", design, tmp_path / "double")
    with pytest.raises(subprocess.CalledProcessError):
        built("gcc", design, tmp_path / "float", "-DHFC_FLOAT", "-fsyntax-only")
    source = code.sources(design)[f"{code.c_name(design)}.c"]
    assert re.search(rf'#error "has to be in double: .*{told}', source)


@pytest.mark.parametrize("flag", ["-ffast-math", "-Ofast", "-ffinite-math-only"])
def test_a_compiler_that_knows_no_nan_is_stopped(flag, tmp_path):
    design = load_design("jee-koren-2004-flc")
    with pytest.raises(subprocess.CalledProcessError):
        built("gcc", design, tmp_path / "c", flag)
    program = built("gcc", design, tmp_path / "d", flag, "-fno-finite-math-only")
    found = commands(program, np.array([[3.0], [np.nan], [np.inf], [4.0]]))
    assert np.isnan(found).tolist() == [False, True, True, False]
