"""What stands in exported C code, and which designs and options it refuses."""

import pytest
from click.testing import CliRunner

from hfc_design.cli import main
from hfc_design.files.pairing import load_design
from hfc_design.formats import FORMATS, code

HOSTILE = 'x); system("id */ int main(void) {\n#define x'


def hfc(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def source(design, folder):
    FORMATS["c"].write(design, folder)
    return (folder / f"{code.c_name(design)}.c").read_text()


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


def test_no_code_comes_with_a_name(tmp_path):
    design = load_design("jee-koren-2004-aflc")
    plant = design.plant.model_copy(update={"name": HOSTILE})
    design = design.model_copy(update={"name": HOSTILE, "plant": plant})
    text = source(design, tmp_path / "c")
    assert "system(" not in text.replace("(_id", "")
    assert "#define x" not in text
    assert text.index("*/") > text.index("stepped every")  # the head ends where it should
    assert code.c_name(design.model_copy(update={"name": "2-axes"})) == "hfc_2_axes"


NARROW = load_design("jee-koren-2004-flc").model_dump(mode="json")["controller"]["error_terms"]
NARROW[0] |= {"right": -14.0}
NARROW[1] |= {"left": -14.0 - 1e-9}
