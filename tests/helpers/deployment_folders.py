"""Folders that code is shipped in, for tests: designs of every sort, their checks and vectors."""

import csv
import re
import subprocess

import made_up
import numpy as np
from exported import texts
from st_program import Program
from whole_machines import DESIGNS

from hfc_design.files.design import builtin_designs, named_design
from hfc_design.formats import FORMATS

STRICT = (
    "-std=c99 -pedantic -Wall -Wextra -Werror -Wdouble-promotion -Wfloat-conversion -Wconversion"
)


#: Every built-in design that has C, axis by axis.
BUILT_IN = {
    f"{name} {axis}".strip(): part
    for name in builtin_designs()
    for axis, part in named_design(name).by_axis().items()
}
RANDOM = {
    "hierarchy": made_up.hierarchy(3),
    "adapting hierarchy": made_up.hierarchy(
        11, 5, adaptation={"k_c": 1e-2, "largest_move": 0.5, "error_scale": 3.0}
    ),
    "linear part within a limit": made_up.limited(made_up.hierarchy_on_linear(5), 300.0),
    "scheduling": made_up.scheduling(4),
    "resonators": made_up.resonating(made_up.linear("lqi", 1), 3, 2.0, 50.0, 900.0),
    "flc of 2 x 11": made_up.named(2, 2, 11),
    "aflc": made_up.fuzzy("aflc", 2),
    "aflc with options": made_up.with_options("aflc", 5),
    "soflc": made_up.fuzzy("soflc", 3),
    "network": made_up.network(4, 5),
}
ALL = BUILT_IN | RANDOM | {f"whole machine {name}": design for name, design in DESIGNS.items()}
#: One of each sort, for what need not be asked of all.
FEW = ["lin-lee-1999-table-1", "huang-soc", "huang-cross-coupled"]


def written(make_folder):
    """The folder of a design by its name, written once; ``make_folder`` gives an empty one."""
    known = {}

    def of(name):
        if name not in known:
            known[name] = make_folder("deployment") / "out"
            FORMATS["c"].write(ALL[name], known[name])
        return known[name]

    return of


def checked(path, flags=STRICT):
    """Exit status and words of its ``make check``."""
    command = ["make", "-C", path, "check", f"WARNINGS={flags}"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    subprocess.run(["make", "-s", "-C", path, "clean"], check=True)
    return done.returncode, done.stdout + done.stderr


def vectors(found):
    """Columns, numbers, and the notes of the file in a folder, or among texts."""
    of_folder = "" if isinstance(found, dict) else (found / "check" / "vectors.csv").read_text()
    lines = (of_folder or found["check/vectors.csv"]).splitlines()
    notes = [line for line in lines if line.startswith("#")]
    names, *rows = csv.reader(line for line in lines if not line.startswith("#"))
    return names, np.array(rows, float), "\n".join(notes)


def passes(path, compared=200):
    """``compared``: so many samples at least do not depend on a rounding of float."""
    status, told = checked(path)
    assert status == 0, told
    found = re.findall(r"(double|float): 1000 samples, of which (\d+) are compared; largest", told)
    assert [precision for precision, _ in found] == ["double", "float"]
    assert int(found[0][1]) == 1000
    assert int(found[1][1]) >= compared, told


def page(design):
    return texts(design, "c")["README.md"]


def runs_in_a_plc(design):
    """Whether the program of the vectors ends well, and does not with another expectation."""
    found = texts(design, "st")
    (block,) = (text for name, text in found.items() if name.endswith(".st") and "/" not in name)
    program = Program(found["check/check.st"], block)
    for k in range(1000):
        assert not program.values["done"], k
        program.cycle()
    assert program.values["done"]
    assert program.values["ok"], program.values["largest_off"]
    assert program.values["faults"] == 0
    names, numbers, _ = vectors(found)
    given = [name for name in program.values if name.startswith("given_")]
    for column, name in enumerate(given, 2):
        assert name.endswith(names[column].rpartition(".")[2])
        assert program.values[name] == numbers[:, column].tolist()
    program.values |= {"k": 999, "tolerance": 0.0}
    expected = next(name for name in program.values if name.startswith("expected_"))
    program.values[expected][999] += 1.0
    program.cycle()
    assert not program.values["ok"]
    assert f"`{program.block}`" in found["README.md"]
