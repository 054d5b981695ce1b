"""Logs that tell nothing, or that somebody made to do harm: a line each, and nothing is left."""

import os
import pickle
import time
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.io import savemat

from hfc_design.cli import main
from hfc_design.core.records import UserError
from hfc_design.identify.sources import called
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


def identify(*arguments, plant=("--plant", "positioning-stage")):
    return CliRunner().invoke(main, ["identify", *map(str, (*plant, *arguments))])


def refused(*arguments, **others):
    """The line of a user error; the folder is as it was before."""
    before = sorted(os.listdir())
    found = identify(*arguments, **others)
    assert found.exit_code == 2, found.output
    assert found.output.count("\n") == 1, found.output
    assert found.output.rstrip("\n").isprintable()
    assert sorted(os.listdir()) == before
    return found.output


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


GOOD = (TIME, PLACE, VOLTS)
LONG = (np.arange(2000) * 1e-3, NOISE, np.sin(np.arange(2000)))
CASES = {
    "nan": (text(GOOD, line58="0.056,nan,0"), "line 58: 'nan' is no finite number"),
    "inf": (text(GOOD, line58="0.056,inf,0"), "line 58: 'inf' is no finite number"),
    "overflow": (text(GOOD, line58="0.056,1e999,0"), "line 58: '1e999' is no finite number"),
    "empty cell": (text(GOOD, line58="0.056,,0"), "line 58: '' is no finite number"),
    "ragged": (text(GOOD, line58="0.056,1"), "line 58: has 2 columns, the first one 3"),
    "hexadecimal": (text(GOOD, line4="0x10,1,1"), "line 4: '0x10' is no finite number"),
    "beyond numbers": (text((TIME, 1e300 * PLACE, VOLTS)), "no numbers up to 1e+100"),
    "no command": (text((TIME, PLACE, 0 * TIME)), "the command is 0 throughout: nothing moves"),
    "stands": (text((TIME, 1 + 0 * TIME, VOLTS)), "the position is 1 throughout: nothing moves"),
    "denormal": (text((TIME, 1e-320 * PLACE, VOLTS)), "throughout: nothing moves"),
    "two seconds of noise": (text(LONG), "the position only trembles by 1e-05 mm (rms)"),
    "empty": ("", "has no samples"),
    "header alone": (HEAD + "\n", "has no samples"),
    "one row": (text([x[:1] for x in GOOD]), "has 1 samples; 20 are the fewest"),
    "too short": (text([x[:40] for x in GOOD]), "has 40 samples, an observer needs 100"),
    "twice": (text((*GOOD, PLACE), HEAD + ",position_mm"), "two columns are called 'position_mm'"),
    "two of one": (
        text((*GOOD, PLACE), HEAD + ",position [um]"),
        "position_mm and position [um] may be the position: which one?",
    ),
    "backwards": (text((TIME[::-1], PLACE, VOLTS)), "its time falls after sample 1"),
    "one stamp back": (text(GOOD, line201="0.1,0,0"), "its time falls after sample 199"),
    "time stands": (text((0 * TIME, PLACE, VOLTS)), "its time stands still"),
    "ms for s": (text((1e3 * TIME, PLACE, VOLTS)), "is sampled every 1 s; a drive's log every"),
    "other kind": (
        text(GOOD, "time_s,position [mV],voltage_V"),
        "column position [mV] for the position: 'mV' cannot be counted in mm; allowed are [mm]",
    ),
    "furlongs": (
        text(GOOD, "time_s,position [furlong],voltage_V"),
        "column position [furlong] in furlong: the position goes 1.21e+03 m in 0.4 s",
    ),
    "escape": (text((*GOOD, PLACE), HEAD + ",\x1b[31mred"), "'\\x1b[31mred' is no name of a"),
    "long name": (text((*GOOD, PLACE), HEAD + "," + 9999 * "x"), "printable, 200 letters at most"),
    "line in a name": (text((*GOOD, PLACE), HEAD + ',"a\nb"'), "line 2: 'b\"' is no finite number"),
    "page": (
        text(GOOD, "time_s,<script>alert(1)</script>,voltage_V"),
        "say position=COLUMN [UNIT] by --column; there is time_s, <script>",
    ),
    "quotes": (text(GOOD, 'time_s,"a, \'""b",voltage_V'), "there is time_s, a, '\"b, voltage_V"),
    "very many": (
        text([TIME] * 999, ",".join(f"c{k}" for k in range(999))),
        "which column is the command?",
    ),
    "zeros": ("\0" * 9999, "has no samples"),
    "UTF-16": (text(GOOD).encode("utf-16"), "it is not a text in UTF-8"),
    "Latin-1": (text(GOOD, "Zeit,µm,V").encode("latin-1"), "convert it: iconv -f cp1252 -t utf-8"),
    "rubbish": (np.random.default_rng(0).bytes(9999), "it is not a text in UTF-8"),
    "packed": (b"\x1f\x8b\x08\x00" + bytes([0xFF] * 99), "it is packed by gzip; unpack it"),
}


@pytest.mark.parametrize("case", CASES)
def test_a_text_that_cannot_be_used_is_refused_in_a_line(case):
    content, words = CASES[case]
    name = "<b>log.csv"
    with open(name, "wb") as file:
        file.write(content if isinstance(content, bytes) else content.encode())
    told = refused(name)
    assert told.startswith("hfc: <b>log.csv: ")
    assert words in told


class Owned:
    """What would be done if somebody unpickled it."""

    def __reduce__(self):
        return os.mkdir, ("owned",)


def test_arrays_that_are_none_are_refused_and_nothing_is_unpickled():
    np.save("object.npy", np.array([Owned()], dtype=object), allow_pickle=True)
    np.savez("object.npz", time_s=np.array([Owned()], dtype=object))
    files = {
        "pickle.npy": pickle.dumps(Owned()),
        "rubbish.npy": np.random.default_rng(0).bytes(9999),
        "rubbish.mat": np.random.default_rng(0).bytes(9999),
        "hdf5.mat": b"\x89HDF\r\n\x1a\n" + bytes(999),
        "v73.mat": b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(512) + b"\x89HDF\r\n\x1a\n",
    }
    for name, content in files.items():
        with open(name, "wb") as file:
            file.write(content)
    savemat("nan.mat", {"time": TIME, "position": np.where(TIME == 0.1, np.nan, PLACE)})
    for name in ("pickle.npy", "object.npy", "object.npz", "rubbish.npy"):
        assert "is no file of NumPy that can be read" in refused(name)
    assert "is no MAT file that can be read" in refused("rubbish.mat")
    assert "is of MATLAB 7.3; save it with -v7" in refused("hdf5.mat")
    assert "is of MATLAB 7.3; save it with -v7" in refused("v73.mat")
    assert "column position: 1 of 400 samples are no numbers" in refused("nan.mat")
    assert not os.path.exists("owned")


@pytest.mark.parametrize("ending", ["csv", "mat", "npy", "npz"])
def test_a_file_of_2_gb_is_refused_without_being_read(ending):
    name = f"log.{ending}"
    with open(name, "wb") as file:
        file.truncate(2_000_000_000)
    begun = time.monotonic()
    with pytest.raises(UserError, match="it has more than 512 MB"):
        read_log(name)
    assert time.monotonic() - begun < 0.2  # its zeros alone take longer to read


def test_what_stands_in_the_way_is_told_before_anything_is_computed():
    with open("log.csv", "w") as file:
        file.write(text(GOOD))
    os.mkdir("there")
    os.mkfifo("pipe.csv")
    assert "--out there: exists already" in refused("log.csv", "--out", "there")
    assert "--out log.csv: is a file" in refused("log.csv", "--out", "log.csv", "--force")
    assert "it is a named pipe" in refused("pipe.csv")
    assert "cannot be read: Is a directory" in refused("there")
    assert "cannot be read: No such file" in refused("nowhere.csv")
    told = refused("log.csv", "--free", "mas,offset")
    assert "mas: positioning-stage has no such parameter; did you mean mass?" in told
    assert "has no such parameter; mass, viscous_friction" in refused("log.csv", "--free", "xyzzy")
    assert "1 Hz does not suit it: 25 to 200 Hz" in refused("log.csv", "--bandwidth", "1")
    assert "300 Hz does not suit it" in refused("log.csv", "--bandwidth", "300")
    assert "which machine is it?" in refused("log.csv", plant=())
    assert "is no signal of c-axis" in refused(
        "log.csv", "--column", "position=position_mm", plant=("--plant", "c-axis")
    )


def test_what_is_mistyped_is_told_before_what_is_in_the_way():
    with open("log.csv", "w") as file:
        file.write(text(GOOD))
    os.mkdir("log-identified")
    assert "log-identified: exists already" in refused("log.csv")
    for out in ((), ("--out", "log-identified"), ("--out", "log.csv", "--force")):
        assert "mas: positioning-stage has no such" in refused("log.csv", "--free", "mas", *out)
        told = refused("log.csv", "--column", "position=q [mV]", *out)
        assert told.startswith("hfc: log.csv: column q for the position: 'mV' cannot be counted")
        assert "speed: is no signal of" in refused("log.csv", "--column", "speed=q", *out)
        assert "has to be NAME=COLUMN" in refused("log.csv", "--column", "position", *out)
        check = "--check-log", "other.csv", "--check-column", "position=q [kg]"
        told = refused("log.csv", *check, *out)
        assert told.startswith("hfc: other.csv: column q for the position: 'kg' cannot be counted")


def test_what_is_piped_in_has_a_name_that_says_something():
    with open("log.csv", "w") as file:
        file.write(text(GOOD))
    reader, writer = os.pipe()
    file = os.open("log.csv", os.O_RDONLY)
    try:
        assert called(Path(f"/dev/fd/{reader}")) == "log"
        assert called(Path(f"/proc/self/fd/{reader}")) == "log"
        assert called(Path(f"/dev/fd/{file}")) == "log.csv"  # hfc identify /dev/stdin < log.csv
    finally:
        for each in (reader, writer, file):
            os.close(each)
    assert called(Path("runs/63")) == "63"
    os.symlink("log.csv", "newest.csv")
    assert called(Path("newest.csv")) == "newest.csv"


def test_a_second_log_that_cannot_check_the_first_is_refused_at_once():
    slow = (2 * TIME, PLACE, VOLTS)
    logs = {"log.csv": (GOOD, HEAD), "slow.csv": (slow, HEAD), "still.csv": (GOOD[:2], HEAD[:18])}
    for name, (columns, head) in logs.items():
        with open(name, "w") as file:
            file.write(text(columns, head))
    assert "slow.csv: is sampled every 0.002 s" in refused("log.csv", "--check-log", "slow.csv")
    assert "which column is the command?" in refused("log.csv", "--check-log", "still.csv")
    with open("still.csv", "w") as file:
        file.write(text(GOOD, "time_s,position_mm,reference_mm"))
    assert "still.csv: has no command" in refused("log.csv", "--check-log", "still.csv")
