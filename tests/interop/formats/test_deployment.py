"""The folder of ``--to c`` compiles, passes its own check, and needs no more than it says.

Its test vectors are those of the runtime, and find a wrong number.
"""

import os
import re
import shutil
import subprocess

import made_up
import pytest
from deployment_folders import ALL, BUILT_IN, FEW, checked, passes, vectors, written
from whole_machines import DESIGNS

from hfc_design.files.loop_setup import load_design
from hfc_design.formats import FORMATS, code, saving
from hfc_design.formats.c_folder import write_lookup
from hfc_design.formats.writing import write


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return written(tmp_path_factory.mktemp)


#: A built-in design of each kind, and what has code of its own beside them.
CHECKED = {design.controller.kind: name for name, design in reversed(BUILT_IN.items())}.values()
CHECKED = [*CHECKED, "adapting hierarchy", "linear part within a limit", "scheduling", "resonators"]
CHECKED += ["flc of 2 x 11", "aflc with options"]
CHECKED += [f"whole machine {x}" for x in ("limits", "one learns", "unlike", "nested")]
CHECKED += ["whole machine slow and learns"]


@pytest.mark.parametrize("name", CHECKED)
def test_every_folder_passes_its_own_check(name, folder):
    # The limit of this one makes inputs so wide that its network learns from errors of 590 units.
    # That amplifies roundings: of the network alone, beside a PID, 75 samples are left, of the
    # aflc 452, and of both where no limit widens the inputs 472.
    passes(folder(name), compared=100 if name == "whole machine unlike" else 200)


def test_one_make_checks_every_axis(tmp_path):
    FORMATS["c"].write(load_design("lin-gai-2009-pid"), tmp_path / "c")
    status, told = checked(tmp_path / "c")
    assert (status, told.count(": ok\n")) == (0, 10), told
    text = (tmp_path / "c" / "README.md").read_text()
    assert re.findall(r"- \[(\w)\]\((\w)/README.md\)", text) == [(x, x) for x in "xyzac"]
    source = tmp_path / "c" / "z" / "lin_gai_2009_pid_z.c"
    source.write_text(source.read_text().replace("inputs->error", "2 * inputs->error"))
    status, told = checked(tmp_path / "c")
    assert status != 0
    assert "FAILED" in told


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
    write(tmp_path / "c", code.sources(ALL[name]))
    assert outside(tmp_path / "c") == NEEDS[name]


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
    write(tmp_path / "c", code.sources(design))
    own = code.c_name(design)
    lines = f'#include <stdio.h>\n#include "{own}.h"\n'
    lines += f'int main(void) {{ printf("%d", (int)sizeof({own}_state)); return 0; }}\n'
    (tmp_path / "c" / "size.c").write_text(lines)
    for k, flags in enumerate(((), ("-DHFC_FLOAT",))):
        command = ["gcc", *flags, tmp_path / "c" / "size.c", "-o", tmp_path / "size"]
        subprocess.run(command, check=True)
        assert int(subprocess.check_output([tmp_path / "size"])) == saving.size(design)[k]


@pytest.mark.parametrize("name", FEW)
def test_the_call_to_begin_with_compiles_as_it_stands(name, folder):
    text = (folder(name) / "README.md").read_text()
    (snippet,) = (x for x in re.findall(r"```c\n(.*?)```", text, re.DOTALL) if "#include" in x)
    for precision in ([], ["-DHFC_FLOAT"]):
        command = [
            "gcc",
            "-std=c99",
            "-Wall",
            "-Wextra",
            "-Werror",
            "-fsyntax-only",
            "-x",
            "c",
            "-",
        ]
        if precision and "must be compiled in double" in text:
            continue
        own = subprocess.run(
            [*command, f"-I{folder(name)}", *precision],
            input=snippet,
            text=True,
            capture_output=True,
            check=False,
        )
        assert own.returncode == 0, own.stderr


#: Where numbers of a table stand in the C of a design.
TABLES = {
    "jee-koren-2004-flc": "real singletons[49] = {",
    "lin-lee-1999-table-1": "real consequents[196] = {",
    "jee-koren-2004-aflc": "real start_singletons[49] = {",
    "huang-neural": "real start_weights_output[26] = {",
}


#: Multiplies one number of a table, which is no constant then, before anything runs.
CHANGED = """
#include <stdlib.h>
__attribute__((constructor)) static void change(void)
{{
    ((real *){table})[atoi(getenv("PLACE"))] *= (real)atof(getenv("FACTOR"));
}}
"""


@pytest.fixture
def judged(folder, tmp_path):
    """Numbers of a design's table; whether a check fails where one of them is multiplied."""

    def of(name, precision):
        copy = shutil.copytree(folder(name), tmp_path / "copy")
        file = next(copy.glob("*.c"))
        before, mark, rest = file.read_text().partition(TABLES[name])
        assert before.endswith("const ")
        change = CHANGED.format(table=mark.split()[1].partition("[")[0])
        file.write_text(f"{before.removesuffix('const ')}{mark}{rest}{change}")
        subprocess.run(["make", "-s", "-C", copy, f"check/{precision}"], check=True)

        def fails(place, factor):
            own = os.environ | {"PLACE": str(place), "FACTOR": str(factor)}
            command = [copy / "check" / precision, copy / "check" / "vectors.csv"]
            done = subprocess.run(command, capture_output=True, text=True, check=False, env=own)
            assert done.stdout.endswith(": ok\n" if done.returncode == 0 else ": FAILED\n")
            return done.returncode == 1

        return [float(x) for x in re.findall(r"R\(([^)]+)\)", rest[: rest.index("};")])], fails

    return of


@pytest.mark.parametrize("name", TABLES)
def test_every_number_of_a_table_that_is_off_by_one_per_cent_is_found(name, judged):
    """Up or down: an adaptation holds a table to its stable range, whatever it starts from."""
    numbers, fails = judged(name, "double")
    found = [fails(k, 1.01) or fails(k, 0.99) for k, x in enumerate(numbers) if x]
    assert len(found) >= 10
    assert all(found), found
