"""Test vectors are those of the runtime, go beyond every range, and find a wrong number."""

import re
import subprocess

import pytest
from flash_folders import written


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return written(tmp_path_factory.mktemp)


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


@pytest.mark.parametrize("precision", ["double", "float"])
@pytest.mark.parametrize("name", ["jee-koren-2004-flc", "lin-lee-1999-table-1"])
def test_a_number_that_is_off_by_one_per_cent_is_found(name, precision, folder):
    path = folder(name)
    source = next(path.glob("*.c")).read_text()
    last = list(mutants(source, TABLES[name]))[-1]  # the rule of a corner
    assert found_wrong(path, last, precision)
    assert not found_wrong(path, source, precision)
