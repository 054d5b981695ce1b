"""The MAT export, read back by SciPy; by Octave: tests/interop/test_mat.py."""

import zipfile

import made_up
import numpy as np
import pytest
from click.testing import CliRunner
from scipy.io import loadmat
from wording import refused

from hfc_design.cli import main
from hfc_design.files.design import Limits, builtin_designs, named_design
from hfc_design.formats import FORMATS, compiling
from hfc_design.formats.fmu.description import base_unit


@pytest.fixture
def read(tmp_path):
    def written(design):
        FORMATS["mat"].write(design, tmp_path / "design.mat")
        return loadmat(tmp_path / "design.mat", simplify_cells=True)

    return written


def same(found, wanted, key=""):
    """Whether SciPy gives what stands in the design file, to the bit."""
    if wanted is None:
        infinite = {"left": -np.inf, "right": np.inf}
        return found == infinite[key] if key in infinite else np.size(found) == 0
    if isinstance(wanted, dict):
        return set(found) == set(wanted) and all(same(found[k], wanted[k], k) for k in wanted)
    if isinstance(wanted, list) and wanted and isinstance(wanted[0], dict):
        items = [found] if isinstance(found, dict) else list(found)
        return len(items) == len(wanted) and all(map(same, items, wanted))
    return np.array_equal(np.array(found), np.array(wanted))


@pytest.mark.parametrize("name", [x for x in builtin_designs() if "" in named_design(x).by_axis()])
def test_scipy_reads_the_design_file_back_bit_for_bit(name, read):
    design = named_design(name)
    found, wanted = read(design), design.model_dump(mode="json")
    assert same(found["controller"], wanted["controller"])
    assert found["design"]["name"] == name
    assert same(found["design"]["plant"]["parameters"], wanted["plant"]["parameters"])
    assert found["design"]["facts"][1].startswith(f"design {name}, sha256 ")


@pytest.mark.parametrize("seed", [3, 7])
def test_a_linear_part_and_a_scheduled_law_are_read_back_too(seed, read):
    """One of them without signals, which is a struct without fields."""
    design = made_up.scheduling(seed)
    found, wanted = read(design)["controller"], design.model_dump(mode="json")["controller"]
    bare = []
    for part in ("linear", "scheduled"):
        signals = wanted[part].pop("signals")
        bare += [] if signals else [part]
        assert same(found[part].pop("signals"), signals) or not signals
    assert bare == ["linear"] * (seed == 3)
    assert same(found, wanted)


def test_the_wiring_counts_inputs_and_then_units_from_1(read):
    found = read(named_design("lin-lee-1999-table-1"))
    # 1 error, 2 deflection, 3 its rate, 4 spindle velocity, 5 the same a sample ago; 6 unit 7, ...
    assert found["wiring"].tolist() == [[4, 5], [6, 2], [7, 1], [8, 3]]
    assert [unit["name"] for unit in found["units"]] == ["unit_7", "unit_3", "unit_1", "unit_0"]
    assert found["units"][0]["table"][0, 1] == 0.4644  # LL Table I, unit 7
    assert read(named_design("jee-koren-2004-flc"))["wiring"].tolist() == [1, 2]


def test_a_name_is_a_string_and_never_a_field(read):
    evil = "x'); system('id"
    good = named_design("lin-lee-1999-table-1")
    assert read(good.model_copy(update={"name": evil}))["design"]["name"] == evil
    plant = good.plant.model_copy(update={"parameters": {evil: 1.0}})
    with refused():
        read(good.model_copy(update={"plant": plant}))


@pytest.mark.parametrize(
    ("unit", "factor", "exponents"),
    [
        ("N m s/rad", 1.0, {"kg": 1, "m": 2, "s": -1, "rad": -1}),
        ("(mm/s)/V", 1e-3, {"m": -1, "s": 2, "kg": -1, "A": 1}),
        ("m/(mm/s)^2", 1e6, {"m": -1, "s": 2}),
        ("ohm", 1.0, {"kg": 1, "m": 2, "s": -3, "A": -2}),
        ("(BLU/s)/unit", None, None),
        ("m)", None, None),
        ("N??", None, None),
    ],
)
def test_units_in_the_base_units_of_fmi(unit, factor, exponents):
    found = base_unit(unit)
    if factor is None:
        assert found is None
    else:
        assert found.factor == pytest.approx(factor, rel=1e-15)
        assert found.exponents == exponents


def test_without_a_compiler_there_are_sources_and_a_line(tmp_path, monkeypatch):
    monkeypatch.setattr(compiling.shutil, "which", lambda name: None)
    monkeypatch.setattr(compiling, "find_spec", lambda name: None)
    found = CliRunner().invoke(
        main, ["export", "pd-only", "--to", "fmu", "--out", str(tmp_path / "a")]
    )
    assert found.exit_code == 0
    assert found.output.splitlines()[0] == compiling.note()
    assert compiling.note().startswith("the FMUs contain no binaries")
    with zipfile.ZipFile(tmp_path / "a" / "pd_only_fmi3.fmu") as archive:
        names = archive.namelist()
    assert "sources/buildDescription.xml" in names
    assert "sources/pd_only.c" in names
    assert not [name for name in names if name.startswith("binaries")]


#: What there is beside the sources of a folder of code.
CHECK = {"Makefile", "README.md", "check/check.c", "check/vectors.csv"}
C = CHECK | {"pd_only.c", "pd_only.h"}
HAL = {"controller.hal", "loop.hal", "reference.txt", "hfc_c_axis.comp", "hfc_pd_only.comp"}
NAMES = {
    "c": C,
    "linuxcnc": C | HAL | {"plant_c_axis.c", "plant_c_axis.h"},
    "st": {"README.md", "check/check.st", "check/vectors.csv", "pd_only.st"},
    "plcopen": {"README.md", "check/check.st", "check/vectors.csv", "pd_only.xml"},
}


@pytest.mark.parametrize(
    "target", [to for to in FORMATS if not to.startswith(("fmu", "heid", "klip"))]
)
def test_the_same_design_gives_the_same_bytes(target, tmp_path):
    own = "huang-pid" if FORMATS[target].parameters else "lin-lee-1999-table-2"
    design = named_design("pd-only" if target in NAMES else own)
    both = []
    for folder in ("a", "b"):
        FORMATS[target].write(design, tmp_path / folder)
        files = [tmp_path / folder, *(tmp_path / folder).rglob("*")]
        found = {
            str(x.relative_to(tmp_path / folder)): x.read_bytes() for x in files if x.is_file()
        }
        both.append(found)
    assert both[0] == both[1]
    assert both[0].keys() == NAMES.get(target, both[0].keys())
    if target in ("fll", "fcl", "fcl-jfuzzylogic", "fml"):
        assert not [text for text in both[0].values() if b"\n\n\n" in text]


def test_a_limit_is_there_where_the_design_has_one(read):
    design = named_design("lin-lee-1999-table-1")
    assert "limits" not in read(design)
    assert read(design.model_copy(update={"limits": Limits(command=9.0)}))["limits"] == {
        "command": 9.0
    }
