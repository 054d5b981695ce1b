"""Damaged and forged files of arrays: a log, or one line, and never more than a gigabyte."""

import io
import random
import struct
import zipfile
import zlib

import checkpoint_arrays
import checkpoint_files
import numpy as np
import pytest
from attack import FULL, SEED, Attack, rounds
from checkpoint_files import npy, zipped
from log_files import written_hdf5, written_mdf, written_tdms
from scipy.io import savemat

from hfc_design.core.records import UserError
from hfc_design.logs import reading
from hfc_design.logs.columns import check_log
from hfc_design.logs.reading import read_log

TIME = np.arange(40) / 1000
#: A log with what forgers of checkpoints look for.
ARRAYS = {"time": TIME, "position": TIME**2, "generation": TIME, "made_by": np.array("{}")}
ARRAYS |= {"format": np.array("a text")}
FORGERS = [getattr(checkpoint_arrays, name) for name in ("another_member", "another_name")]
FORGERS += [getattr(checkpoint_arrays, f"another_{of}") for of in ("header", "size", "type")]
FORGERS += [checkpoint_arrays.one_less, checkpoint_arrays.some_twice]
FORGERS += checkpoint_files.REFUSED + checkpoint_files.EITHER
HEAD = b"MATLAB 5.0 MAT-file".ljust(124) + b"\0\1IM"


def outcome(file, content):
    """A word for what comes of a file with this content."""
    file.write_bytes(content)
    try:
        log = read_log(file)
    except UserError as error:
        assert str(error).startswith(f"{file}: "), error
        assert str(error).isprintable(), error
        assert len(str(error)) - len(str(file)) < 300, error
        assert "unsafe" not in str(error), error
        assert "pickle" not in str(error), error
        return "refused"
    assert check_log(log).rows >= 20
    return "read"


@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_files_of_numpy(tmp_path):
    """Forged archives, then each header alone, then more zeros than an entry tells."""
    draw, attack = random.Random(f"{SEED} numpy"), Attack("forged NPZ and NPY")
    good = zipped(checkpoint_files.replaced(ARRAYS))
    assert attack.input(outcome, tmp_path / "log.npz", good) == "read"
    for k in range(rounds(4, 100) * len(FORGERS)):
        attack.input(outcome, tmp_path / "log.npz", FORGERS[k % len(FORGERS)](ARRAYS, draw))
    headers = [npy(0, 0, TIME.tobytes(), header=told) for told in checkpoint_arrays.HEADERS]
    headers += [npy("<f8", shape, TIME.tobytes()) for shape in checkpoint_arrays.SHAPES]
    headers += [npy(descr, (40,), TIME.tobytes()) for descr in checkpoint_arrays.TYPES]
    for content in headers:
        attack.input(outcome, tmp_path / "log.npy", content)
    bomb = bytearray(zipped([("x.npy", zeros(npy("<f8", (9,), b"")) + b"\3\0")]))
    entry = bomb.rindex(b"PK\1\2")
    bomb[8], bomb[entry + 10] = 2 * [zipfile.ZIP_DEFLATED]
    for size in (200, 4 * 10**9):
        bomb[entry + 24 : entry + 28] = size.to_bytes(4, "little")
        assert attack.input(outcome, tmp_path / "log.npz", bytes(bomb)) == "refused"
    assert attack.outcomes.total() > 80
    attack.end(full=FULL)


def zeros(before):
    """What deflate makes of some bytes and gigabytes of zeros behind them, without its end."""
    parts, packer = [], zlib.compressobj(9, wbits=-15)
    for data in (before, bytes(10**7)):
        parts.append(packer.compress(data) + packer.flush(zlib.Z_FULL_FLUSH))
    return parts[0] + rounds(150, 600) * parts[1]


def packed(data):
    return HEAD + element(15, zlib.compress(data, 1))


def element(kind, data, size=None):
    return struct.pack("<II", kind, len(data) if size is None else size) + data


def matrix(kind, *parts, shape=(40, 1), name=b"time\0\0\0\0"):
    flags = struct.pack("<II", kind, 0)
    sizes = np.array(shape, "<i4").tobytes()
    first = element(6, flags) + element(5, sizes + bytes(-len(sizes) % 8), len(sizes))
    return element(14, first + element(1, name) + b"".join(parts))


def nested(levels):
    found = matrix(6, element(9, TIME.tobytes()))
    for _ in range(levels):
        found = matrix(2, element(5, b"\1\0\0\0\0\0\0\0", 4), element(1, b"a" + bytes(7), 1), found,
                       shape=(1, 1))  # fmt: skip
    return found


NUMBERS = element(9, TIME.tobytes())
#: Files that lie, a way each.
LIES = [
    *(matrix(6, element(kind, TIME.tobytes())) for kind in (0, 14, 15, 99, 7, 4, 18, 2**31)),
    *(matrix(6, element(9, TIME.tobytes(), size)) for size in (0, 1, 319, 321, 2**31, 2**32 - 1)),
    *(matrix(kind, NUMBERS) for kind in (0, 1, 2, 3, 4, 5, 7, 15, 16, 17, 18, 255)),
    *(matrix(kind, NUMBERS) for kind in (0x806, 0xFFFFFF06)),
    *(matrix(6, NUMBERS, shape=s) for s in ((), (40,), (-40, -1), (2**31 - 1,) * 9, (1,) * 9999)),
    *(matrix(2, element(5, struct.pack("<i", n) + bytes(4), 4), element(1, b"a" * 8), shape=(2, 2))
      for n in (0, -1, 1, 2**31 - 1)),
    matrix(2, element(5, bytes([1] + [0] * 7), 4), element(1, b""), shape=(2**15, 2**15)),
    *(nested(levels) for levels in (3, 900)),
    matrix(17, element(1, b"MCOS" * 2), element(1, b"\xff" * 8), NUMBERS),
    matrix(4, element(17, b"\0\xd8" * 4)),
    element(14, b"") * 30_000,
    element(9, TIME.tobytes()),
    matrix(6, NUMBERS, name=b"\x1b[31m\n\0\0"),
]  # fmt: skip


def test_files_of_matlab(tmp_path):
    """Those that lie, plain and packed; packed zeros; valid ones with bits flipped."""
    draw, attack, file = random.Random(f"{SEED} mat"), Attack("forged MAT"), tmp_path / "log.mat"
    assert attack.input(outcome, file, HEAD + matrix(6, NUMBERS)) == "read"
    for content in LIES:
        assert attack.input(outcome, file, HEAD + content) in ("read", "refused")
        attack.input(outcome, file, packed(content))
    bomb = b"\x78\1" + zeros(struct.pack("<II", 14, 2**32 - 1))
    assert attack.input(outcome, file, HEAD + element(15, bomb)) == "refused"
    attack.input(outcome, file, packed(element(15, zlib.compress(matrix(6, NUMBERS)))))
    assert attack.outcomes.total() > 31
    data = {"time": TIME, "out": {"time": TIME, "signals": {"values": TIME, "label": "x"}}}
    for compressed in (True, False):
        buffer = io.BytesIO()
        savemat(buffer, data, do_compression=compressed)
        for _ in range(rounds(20, 2000)):
            bad = bytearray(buffer.getvalue())
            bad[draw.randrange(len(bad))] ^= 1 << draw.randrange(8)
            attack.input(outcome, file, bytes(bad))
    attack.end(full=FULL)


@pytest.mark.parametrize("kind", ["mf4", "tdms", "h5"])
def test_files_of_libraries(tmp_path, kind, monkeypatch):
    """Valid files with bits flipped, of which some would keep a library busy for ever."""
    draw, attack, file = random.Random(f"{SEED} {kind}"), Attack(f"forged {kind}"), tmp_path / kind
    log = file.with_name(f"log.{kind}")
    {"mf4": written_mdf, "tdms": written_tdms, "h5": written_hdf5}[kind](log)
    good = log.read_bytes()
    assert attack.input(outcome, log, good) == "read"
    monkeypatch.setattr(reading, "LONGEST", 10)
    for _ in range(rounds(20, 2000)):
        bad = bytearray(good)
        for _ in range(draw.choice((1, 1, 8))):
            bad[draw.randrange(len(bad))] ^= 1 << draw.randrange(8)
        attack.input(outcome, log, bytes(bad))
    attack.end(full=FULL)
