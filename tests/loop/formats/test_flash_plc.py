"""A PLC, of which tests/helpers/st_program.py has the language, runs the vectors of a block."""

import pytest
from flash_folders import ALL, vectors
from st_program import Program

from hfc_design.formats import FORMATS

ST = ["pd-only", "jee-koren-2004-flc"]


def runs_in_a_plc(design, folder):
    """Whether the program of the vectors ends well, and does not with another expectation."""
    FORMATS["st"].write(design, folder)
    (block,) = (path.read_text() for path in folder.glob("*.st"))
    text = (folder / "check" / "check.st").read_text()
    program = Program(text, block)
    for k in range(1000):
        assert not program.values["done"], k
        program.cycle()
    assert program.values["done"]
    assert program.values["ok"], program.values["largest_off"]
    assert program.values["faults"] == 0
    names, numbers, _ = vectors(folder)
    for column in range(2, len(names) - 1):
        assert program.values[f"given_{names[column]}"] == numbers[:, column].tolist()
    program.values |= {"k": 999, "tolerance": 0.0}
    program.values["expected"][999] += 1.0
    program.cycle()
    assert not program.values["ok"]
    text = (folder / "README.md").read_text()
    assert f"`{program.block}`" in text


@pytest.mark.parametrize("name", ST)
def test_a_plc_runs_the_vectors(name, tmp_path):
    runs_in_a_plc(ALL[name], tmp_path / "st")


def test_a_project_for_a_plc_has_the_same(tmp_path):
    for target in ("st", "plcopen"):
        FORMATS[target].write(ALL["jee-koren-2004-flc"], tmp_path / target)
    for file in ("check/check.st", "check/vectors.csv"):
        assert (tmp_path / "st" / file).read_text() == (tmp_path / "plcopen" / file).read_text()
    names = {path.name for path in (tmp_path / "plcopen").iterdir()}
    assert names == {"README.md", "check", "jee_koren_2004_flc.xml"}
