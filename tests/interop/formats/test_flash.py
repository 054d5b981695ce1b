"""The folder of ``--to c`` compiles, passes its own check, and needs no more than it says."""

import subprocess

import made_up
import pytest
from flash_folders import ALL, FEW, passes, vectors, written
from whole_machines import DESIGNS

from hfc_design.formats import FORMATS, code, machine_code, saving
from hfc_design.formats.c_folder import write_lookup
from hfc_design.formats.writing import write


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return written(tmp_path_factory.mktemp)


@pytest.mark.parametrize("name", FEW)
def test_the_folder_passes_its_own_check(name, folder):
    passes(folder(name))


def test_the_folder_for_linuxcnc_passes_it_too(tmp_path):
    FORMATS["linuxcnc"].write(ALL["jee-koren-2004-flc"], tmp_path / "hal")
    passes(tmp_path / "hal")
    text = (tmp_path / "hal" / "README.md").read_text()
    assert "make check" in text
    assert "The command is not limited" in text
    assert "1 BLU is 0.01 mm" in text
    assert "source: Jee & Koren 2004" in text


NEEDS = {
    "lin-lee-1999-table-1": {"expf"},
    "huang-neural": {"tanhf"},
    "huang-cross-coupled": {"sqrtf"},
    "jee-koren-2004-aflc": set(),
}


def outside(folder):
    """What the sources of a folder, in float, need of a library, and memory that they take."""
    files = sorted(path.name for path in folder.glob("*.c"))
    flags = ("-std=c99", "-O1", "-DHFC_FLOAT", "-ffreestanding", "-fno-pic", "-c")
    subprocess.run(["gcc", *flags, *files], cwd=folder, check=True)
    objects = [file.replace(".c", ".o") for file in files]
    told = subprocess.check_output(["nm", *objects], cwd=folder, text=True)
    symbols = [line.split()[-2:] for line in told.splitlines() if " " in line]
    own = {name for kind, name in symbols if kind == "T"}
    assert {kind for kind, _ in symbols} <= {"T", "t", "r", "U"}  # code and constant tables
    # A compiler may copy and clear memory with these wherever it likes.
    return {name for kind, name in symbols if kind == "U"} - own - {"memcpy", "memset"}


@pytest.mark.parametrize("name", NEEDS)
def test_float_needs_one_function_at_most_and_no_heap(name, tmp_path):
    write(tmp_path / "c", machine_code.sources(ALL[name]))
    assert outside(tmp_path / "c") == NEEDS[name]


def test_a_lookup_in_float_needs_nothing(tmp_path):
    write(tmp_path / "c", code.tabulated(ALL["lin-lee-1999-table-1"], 9)[0])
    assert outside(tmp_path / "c") == set()


SCHEDULING = made_up.limited(made_up.scheduling(5), 60.0)


@pytest.mark.parametrize("made", [None, SCHEDULING])
def test_a_lookup_passes_too_and_needs_no_library(made, tmp_path):
    write_lookup(made or ALL["lin-lee-1999-table-1"], tmp_path / "c", 33)
    passes(tmp_path / "c")
    assert "LDLIBS =\n" in (tmp_path / "c" / "Makefile").read_text()
    assert "tabulated at 33 values" in vectors(tmp_path / "c")[2]
    assert "tabulated at 33 values" in (tmp_path / "c" / "README.md").read_text()


@pytest.mark.parametrize(
    "name", ["pd-only", "jee-koren-2004-aflc", *map("whole machine {}".format, DESIGNS)]
)
def test_the_size_of_a_state_is_that_of_the_compiler(name, tmp_path):
    design = ALL[name]
    write(tmp_path / "c", machine_code.sources(design))
    own = code.c_name(design)
    lines = f'#include <stdio.h>\n#include "{own}.h"\n'
    lines += f'int main(void) {{ printf("%d", (int)sizeof({own}_state)); return 0; }}\n'
    (tmp_path / "c" / "size.c").write_text(lines)
    for k, flags in enumerate(((), ("-DHFC_FLOAT",))):
        command = ["gcc", *flags, tmp_path / "c" / "size.c", "-o", tmp_path / "size"]
        subprocess.run(command, check=True)
        assert int(subprocess.check_output([tmp_path / "size"])) == saving.size(design)[k]
