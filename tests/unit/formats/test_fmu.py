"""FMUs without a compiler: units, what they refuse."""

import zipfile

import pytest
from click.testing import CliRunner

from hfc_design.cli import main
from hfc_design.formats import compiling
from hfc_design.formats.fmu.description import base_unit


@pytest.mark.parametrize(
    ("unit", "factor", "exponents"),
    [
        ("N m s/rad", 1.0, {"kg": 1, "m": 2, "s": -1, "rad": -1}),
        ("rad/s2", 1.0, {"rad": 1, "s": -2}),
        ("(mm/s)/V", 1e-3, {"m": -1, "s": 2, "kg": -1, "A": 1}),
        ("m/(mm/s)^2", 1e6, {"m": -1, "s": 2}),
        ("ohm", 1.0, {"kg": 1, "m": 2, "s": -3, "A": -2}),
        ("1", 1.0, {}),
        ("(BLU/s)/unit", None, None),
        ("m)", 1.0, {"m": 1}),
        ("N??", None, None),
        ("", None, None),
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
    found = CliRunner().invoke(
        main, ["export", "pd-only", "--to", "fmu", "--out", str(tmp_path / "a")]
    )
    assert found.exit_code == 0
    assert found.output.splitlines()[0] == compiling.note()
    assert compiling.note().startswith("found no C compiler (cc)")
    with zipfile.ZipFile(tmp_path / "a" / "pd_only_fmi3.fmu") as archive:
        names = archive.namelist()
    assert "sources/buildDescription.xml" in names
    assert "sources/pd_only.c" in names
    assert not [name for name in names if name.startswith("binaries")]
