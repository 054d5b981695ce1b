"""The same design gives the same files, byte for byte; those of FMUs: tests/interop."""

import pytest

from hfc_design.files.design import named_design
from hfc_design.formats import FORMATS

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


@pytest.mark.parametrize("target", [to for to in FORMATS if not to.startswith("fmu")])
def test_the_same_design_gives_the_same_bytes(target, tmp_path):
    design = named_design("pd-only" if target in NAMES else "lin-lee-1999-table-2")
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
