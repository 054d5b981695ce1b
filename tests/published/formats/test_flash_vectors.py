"""Test vectors are those of the runtime, go beyond every range, and find a wrong number."""

import re
import subprocess

import numpy as np
import pytest
from flash_folders import ALL, FEW, vectors, written

from hfc_design.controllers.controller import PathView
from hfc_design.runtime import Controller, Machine


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return written(tmp_path_factory.mktemp)


def of_the_runtime(design, names, numbers):
    """The commands for the inputs in the columns."""
    axes = [name.removesuffix("command").strip(".") for name in names if name.endswith("command")]
    controller, found = Controller(design) if axes == [""] else Machine(design, tuple(axes)), []
    for row in numbers.tolist():
        told = {axis: {} for axis in [*axes, "path"]}
        for name, x in zip(names, row, strict=True):
            axis, _, signal = name.rpartition(".")
            told[axis if axis in told else axes[0]][signal] = x
        if row[0]:
            controller.reset()
        if axes == [""]:
            found.append([controller.step(told[""])])
            continue
        way = told.pop("path")
        tangent = (way.pop("tangent_x"), way.pop("tangent_y")) if way else None
        found.append(
            list(controller.step(told, PathView(tangent, **way) if way else None).values())
        )
    return found


@pytest.mark.parametrize("name", FEW)
def test_the_vectors_are_those_of_the_runtime(name, folder):
    names, numbers, _ = vectors(folder(name))
    expected = of_the_runtime(ALL[name], names, numbers)
    commands = [k for k, x in enumerate(names) if x.endswith("command")]
    np.testing.assert_array_equal(numbers[:, commands], expected)


#: Where numbers of a table stand in the C of a design.
TABLES = {
    "jee-koren-2004-flc": "real table[ERROR_TERMS][CHANGE_TERMS] = {",
    "lin-lee-1999-table-1": "real table_3[RULES] = {",
    "jee-koren-2004-aflc": "real start_table[ERROR_TERMS][CHANGE_TERMS] = {",
    "huang-neural": "real start_output[UNITS + 1] = {",
}


def mutants(source, mark, factor=1.01):
    """The C with each number of a table 1 % larger, one after the other."""
    begin = source.index(mark) + len(mark)
    for found in re.finditer(r"R\(([^)]+)\)", source[begin : source.index("};", begin)]):
        if value := float(found[1]):
            first, last = begin + found.start(), begin + found.end()
            yield f"{source[:first]}R({factor * value!r}){source[last:]}"


def found_wrong(folder, source, precision):
    """Whether a check ends with an error for another ``source`` of the folder."""
    place, target = next(folder.glob("*.c")), f"check/{precision}"
    kept = place.read_text()
    place.write_text(source)
    try:
        subprocess.run(["make", "-s", "-B", "-C", folder, target], check=True)
        command = [folder / target, folder / "check" / "vectors.csv"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.stdout.endswith(": ok\n" if done.returncode == 0 else ": FAILED\n")
        return done.returncode == 1
    finally:
        place.write_text(kept)
        subprocess.run(["make", "-s", "-C", folder, "clean"], check=True)


@pytest.mark.parametrize("name", TABLES)
def test_every_number_of_a_table_that_is_off_by_one_per_cent_is_found(name, folder):
    """Up or down: an adaptation holds a table to its stable range, whatever it starts from."""
    path = folder(name)
    source = next(path.glob("*.c")).read_text()
    pairs = zip(*(mutants(source, TABLES[name], x) for x in (1.01, 0.99)), strict=True)
    found = [any(found_wrong(path, one, "double") for one in pair) for pair in pairs]
    assert len(found) >= 10
    assert all(found), found
