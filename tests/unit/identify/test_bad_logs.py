"""Logs that tell nothing, or that somebody made to do harm: a line each, and nothing is left."""

import os
import pickle
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
import wording
from run_folders import hfc
from scipy.io import savemat
from wording import refused_command

from hfc_design.identify.recording import log_name
from hfc_design.logs.reading import read_log

TIME = np.arange(400) * 1e-3
PLACE = 3.0 * np.sin(20 * TIME)  # [mm]
VOLTS = np.sin(20 * TIME + 1)
HEAD = "time_s,position_mm,voltage_V"
NOISE = 1e-5 * np.random.default_rng(0).normal(size=2000)


def text(columns, head=HEAD, **lines):
    """A CSV file; ``lines`` are put in the place of others, by the number that they have."""
    rows = [head, *(",".join(f"{x:.9g}" for x in row) for row in zip(*columns, strict=True))]
    for place, line in lines.items():
        rows[int(place.removeprefix("line")) - 1] = line
    return "\n".join(rows) + "\n"


STAGE = ("--plant", "positioning-stage")


def refused(*arguments, plant=STAGE):
    """What the one line of a user error is about; the folder is as it was before."""
    before = sorted(os.listdir())
    found = refused_command("identify", *plant, *arguments)
    assert found.count("\n") == 1
    assert found.rstrip("\n").isprintable()
    assert sorted(os.listdir()) == before
    return found.where


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


GOOD = (TIME, PLACE, VOLTS)
LONG = (np.arange(2000) * 1e-3, NOISE, np.sin(np.arange(2000)))


def put(name, content):
    with open(name, "wb") as file:
        file.write(content if isinstance(content, bytes) else content.encode())


#: What a file holds, and the line that is at fault where it is a line.
CASES = {
    "nan": (text(GOOD, line58="0.056,nan,0"), 58),
    "line in a name": (text((*GOOD, PLACE), HEAD + ',"a\nb"'), 2),
    "denormal": text((TIME, 1e-320 * PLACE, VOLTS)),
    "two seconds of noise": text(LONG),
    "ms for s": text((1e3 * TIME, PLACE, VOLTS)),
    "page": text(GOOD, "time_s,<script>alert(1)</script>,voltage_V"),
    "very many": text([TIME[:40]] * 999, ",".join(f"c{k}" for k in range(999))),
    "rubbish": np.random.default_rng(0).bytes(9999),
}


@pytest.mark.parametrize("case", CASES)
def test_a_text_that_cannot_be_used_is_refused_in_a_line(case):
    content, *line = CASES[case] if isinstance(CASES[case], tuple) else (CASES[case],)
    put("<b>log.csv", content)
    assert refused("<b>log.csv") == "<b>log.csv" + "".join(f": line {n}" for n in line)


class Owned:
    """What would be done if somebody unpickled it."""

    def __reduce__(self):
        return os.mkdir, ("owned",)


def test_arrays_that_are_none_are_refused_and_nothing_is_unpickled():
    """NumPy and SciPy say why, each version in its words."""
    np.save("object.npy", np.array([Owned()], dtype=object), allow_pickle=True)
    np.savez("object.npz", time_s=np.array([Owned()], dtype=object))
    put("pickle.npy", pickle.dumps(Owned()))
    put("rubbish.mat", np.random.default_rng(0).bytes(9999))
    for name in ("pickle.npy", "object.npy", "object.npz", "rubbish.mat"):
        told = hfc("identify", *STAGE, name)
        kind = "MAT file" if name.endswith("mat") else "NumPy file"
        assert told.stderr.startswith(f"hfc: {name}: is not a readable {kind}: ")
        assert (told.exit_code, told.output.count("\n")) == (2, 1)
    assert not os.path.exists("owned")
    savemat("nan.mat", {"time": TIME, "position": np.where(TIME == 0.1, np.nan, PLACE)})
    assert refused("nan.mat") == "nan.mat"


@pytest.mark.parametrize("ending", ["csv", "mat", "npy", "npz"])
def test_a_file_of_2_gb_is_refused_without_being_read(ending):
    name = f"log.{ending}"
    with open(name, "wb") as file:
        file.truncate(2_000_000_000)
    tracemalloc.start()
    with wording.refused() as found:
        read_log(name)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert found.where == name
    assert most < 10_000_000


def test_what_stands_in_the_way_is_told_before_anything_is_computed():
    put("log.csv", text(GOOD))
    os.mkdir("there")
    os.mkfifo("pipe.csv")
    assert refused("log.csv", "--out", "there") == "--out there"
    assert refused("log.csv", "--out", "log.csv", "--force") == "--out log.csv"
    for name in ("pipe.csv", "there", "nowhere.csv"):
        assert refused(name) == name
    for name in ("mas", "xyzzy"):
        assert refused("log.csv", "--free", f"{name},offset") == f"--free {name}"
    for bandwidth in (1, 300):
        refused("log.csv", "--bandwidth", bandwidth)
    refused("log.csv", plant=())
    refused("log.csv", "--column", "position=position_mm", plant=("--plant", "c-axis"))


def test_what_is_piped_in_has_a_name_that_says_something():
    put("log.csv", text(GOOD))
    reader, writer = os.pipe()
    file = os.open("log.csv", os.O_RDONLY)
    try:
        assert log_name(Path(f"/dev/fd/{reader}")) == "log"
        assert log_name(Path(f"/proc/self/fd/{reader}")) == "log"
        assert log_name(Path(f"/dev/fd/{file}")) == "log.csv"  # hfc identify /dev/stdin < log.csv
    finally:
        for each in (reader, writer, file):
            os.close(each)
    assert log_name(Path("runs/63")) == "63"
    os.symlink("log.csv", "newest.csv")
    assert log_name(Path("newest.csv")) == "newest.csv"


def test_a_second_log_that_cannot_check_the_first_is_refused_at_once():
    slow = (2 * TIME, PLACE, VOLTS)
    logs = {"log.csv": (GOOD, HEAD), "slow.csv": (slow, HEAD), "still.csv": (GOOD[:2], HEAD[:18])}
    for name, (columns, head) in logs.items():
        put(name, text(columns, head))
    for name in ("slow.csv", "still.csv"):
        assert refused("log.csv", "--check-log", name) == name
    put("still.csv", text(GOOD, "time_s,position_mm,reference_mm"))
    assert refused("log.csv", "--check-log", "still.csv") == "still.csv"


def test_what_is_known_is_not_looked_for_too():
    put("log.csv", text(GOOD))
    known = ("--set", "plant.parameters.mass=90", "--set", "load.constant=5")
    assert refused("log.csv", *known, "--free", "offset,mass") == "--free mass"
    assert refused("log.csv", *known, "--free", "load=3") == "--free load"
    assert refused("log.csv", "--free", "mass=heavy") == "--free mass"
    assert refused("log.csv", "--free", "mass=-3") == "--free mass"
