"""Damaged and forged checkpoints: one line, or exactly what the undisturbed run ends with.

The oracle is the run that nobody has touched. Numbers that a search could have had cannot be told
from those that it had, by whoever can compute a digest: none of these attacks forges such ones.
"""

import ast
import io
import json
import random
import shutil
import zipfile
from functools import cache
from hashlib import sha256
from typing import NamedTuple

import numpy as np
import pytest
from attack import SEED, Attack, rounds

from hfc_design.core import archive
from hfc_design.core.records import UserError
from hfc_design.files.scenario import load_scenario
from hfc_design.runs import run as design

SIZES = ["search.generations=6", "search.population=12"]
INPUTS = "[{name='error', scale=0.5}, {name='error_rate', scale=0.1}, {name='velocity', scale=0.1}]"
HIERARCHY = f"{{kind='pd+hierarchical-fuzzy', inputs={INPUTS}}}"
ON_LINEAR = f"controller={{inputs={INPUTS.replace('velocity', 'spindle_velocity')}, linear={{}}}}"
PER_AXIS = f"controller={{kind='per-axis', axes={{x={HIERARCHY}, y={{kind='pid'}}}}}}"
#: Scenario and changes of it; those that take long to compile are for ``make test-all``.
SEARCHES = {
    "pd": ("c-axis-ramp", ["controller={kind='pd'}", "simulation.duration_s=0.1"]),
    "lin-lee": ("c-axis-ramp", ["search.preset=lin-lee-1999", "simulation.duration_s=0.1"]),
    "race": ("c-axis-ramp", ["simulation.duration_s=0.1"]),
    "cma": ("c-axis-ramp", [ON_LINEAR, "search.preset=cma", "simulation.duration_s=0.1"]),
    "scheduling": (
        "c-axis-ramp",
        [
            ON_LINEAR.replace("linear=", "schedules=true, linear="),
            "search.preset=cma",
            "simulation.duration_s=0.1",
        ],
    ),
    "flc": ("feed-drive-circle", ["controller.kind=flc", "simulation.duration_s=1.0"]),
    "aflc": ("feed-drive-contour", ["controller.kind=aflc", "simulation.duration_s=1.0"]),
    "per-axis": ("feed-drive-circle", [PER_AXIS, "simulation.duration_s=1.0"]),
}
QUICK = ("pd",)
FILES = ("design.json", "history.csv", "checkpoint.npz")


class Base(NamedTuple):
    """A run that was broken off, and what it ends with if nobody touches it."""

    folder: object  # to be resumed
    ended: dict[str, bytes]
    content: bytes  # of the checkpoint
    name: str

    def outcome(self, content, anyway=False):
        """A word for what comes of the run with this for a checkpoint."""
        for name in FILES:
            (self.folder / name).unlink(missing_ok=True)
        (self.folder / "checkpoint.npz").write_bytes(content)
        try:
            design.run(design.opened_run(self.folder), self.folder, anyway=anyway)
        except UserError as error:
            assert (self.folder / "checkpoint.npz").read_bytes() == content
            assert not (self.folder / "design.json").exists()
            assert "checkpoint.npz: " in str(error), error
            assert str(error).isprintable(), error
            assert len(str(error)) < 600, error
            return "refused"
        assert {name: (self.folder / name).read_bytes() for name in FILES} == self.ended
        return "undisturbed"


class Stop(Exception):
    pass


def stop(search):
    if search.generation == 3:
        raise Stop


@pytest.fixture(
    scope="module",
    params=[x if x in QUICK else pytest.param(x, marks=pytest.mark.slow) for x in SEARCHES],
)
def base(request, tmp_path_factory):
    name, changes = SEARCHES[request.param]
    scenario = load_scenario(name, [*SIZES, *changes])
    whole, part = (tmp_path_factory.mktemp("runs") / kind for kind in ("whole", "part"))
    design.run(design.new_run(scenario, whole), whole)
    own = design.new_run(scenario, part)
    with pytest.raises(Stop):
        design.run(own, part, stop)
    ended = {name: (whole / name).read_bytes() for name in FILES}
    return Base(part, ended, (part / "checkpoint.npz").read_bytes(), request.param)


def drawn(base):
    return random.Random(f"{SEED} {base.name}")


def with_digest(content):
    """A zip file whose digest is right, whatever is in it."""
    return content[:-64] + sha256(content[:-64]).hexdigest().encode()


def of_version_2(content):
    """The checkpoint as an earlier version wrote it: no digest, nothing of what made it."""
    arrays = {k: v for k, v in archive.unpacked(content).items() if k != "made_by"}
    buffer = io.BytesIO()
    np.savez(buffer, **{**arrays, "format": np.array("hfc-checkpoint-2"), "config": np.array("")})
    return buffer.getvalue()


def damaged(content, draw):
    """A content as a bad disk, a broken copy or a fallen machine leaves it."""
    size, found = len(content), bytearray(content)
    kind = draw.choice(["bits", "cut", "zeros", "swapped", "longer", "noise", "double", "lost"])
    start = draw.randrange(size)
    end = min(size, start + draw.choice([1, 16, 512, 4096]))
    if kind == "bits":
        for _ in range(draw.choice([1, 1, 1, 8, 100])):
            found[draw.randrange(size)] ^= 1 << draw.randrange(8)
    elif kind == "cut":
        del found[start:]
    elif kind == "zeros":
        found[start:end] = bytes(end - start)
    elif kind == "swapped":
        block = draw.choice([16, 512, 4096])
        one, other = (draw.randrange(size // block + 1) * block for _ in range(2))
        a, b = bytes(found[one : one + block]), bytes(found[other : other + block])
        if len(a) == len(b):
            found[one : one + block], found[other : other + block] = b, a
    elif kind == "longer":
        found += draw.randbytes(draw.choice([1, 22, 1000]))
    elif kind == "noise":
        found[start:end] = draw.randbytes(end - start)
    elif kind == "double":
        found[start:start] = found[start:end]
    else:
        del found[start:end]
    return bytes(found)


def test_damaged(base):
    """One per checkpoint of a hundred is of an earlier version, which has no digest."""
    draw, attack = drawn(base), Attack(f"damaged checkpoints: {base.name}")
    assert base.outcome(base.content) == "undisturbed"
    old = of_version_2(base.content)
    assert base.outcome(old, anyway=True) == "undisturbed"
    for k in range(rounds(100, 10_000 // len(SEARCHES) + 1)):
        earlier = k % 100 == 99
        good = content = old if earlier else base.content
        while content == good:  # zeros in place of zeros
            content = damaged(good, draw)
        outcome = attack.input(base.outcome, content, earlier)
        assert outcome == "refused" or earlier
    attack.end()


# --- Forged ones: each gives the members of a zip file, or the file itself.


def npy(descr, shape, data, order=False, version=b"\1\0", header=None):
    """An array as a file spells it."""
    told = header or repr({"descr": descr, "fortran_order": order, "shape": shape})
    text = told.encode("latin1", "replace")
    text += b" " * (-(len(text) + 11) % 64) + b"\n"
    return b"\x93NUMPY" + version + (len(text) & 0xFFFF).to_bytes(2, "little") + text + data


def plain(array):
    array = np.asarray(array)
    return npy(array.dtype.str, array.shape, array.tobytes())


def zipped(members, method=zipfile.ZIP_STORED):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", method) as file:
        for name, content in members:
            file.writestr(zipfile.ZipInfo(name), content, method)
    content = buffer.getvalue()[:-2] + b"\x40\x00" + bytes(64)
    return with_digest(content)


def replaced(arrays, **changes):
    """The members with other arrays, or other files where bytes are given."""
    both = {**arrays, **{key.replace("__", "."): value for key, value in changes.items()}}
    return [
        (f"{key}.npy", value if isinstance(value, bytes) else plain(value))
        for key, value in both.items()
    ]


HEADERS = [
    "{'descr': '<f8', 'fortran_order': False, 'shape': (" + "(" * 3000 + "1" + ")" * 3000 + ",)}",
    "__import__('os').system('true')",
    "{'descr': '<f8', 'fortran_order': False}",
    "{'descr': '<f8', 'fortran_order': False, 'shape': (3,), 'more': 1}",
    "{'descr': '<f8', 'fortran_order': 2, 'shape': (3,)}",
    "{'descr': '<f8', 'fortran_order': False, 'shape': (3L,)}",
    "{'descr': ('<f8', (3,)), 'fortran_order': False, 'shape': ()}",
    "{'descr': '<f8', 'fortran_order': False, 'shape': [3]}",
    "{'descr': '<f8', 'fortran_order': False, 'shape': (" + "9" * 5000 + ",)}",
    "{'descr': '<U999999999', 'fortran_order': False, 'shape': (3,)}",
    "{'descr': '<U0', 'fortran_order': False, 'shape': (999999999999,)}",
    "{'descr': '|V0', 'fortran_order': False, 'shape': (999999999999,)}",
    "{'descr': '\xe9', 'fortran_order': False, 'shape': ()}",
    "\0" * 100,
    "[" * 9000,
    " " * 20_000,
]
SHAPES = [(10**12,), (2**62, 2**62), (-3,), (-1, -3), (0,), (2**63,), (3, 0), (True,), ()]
TYPES = ["O", ">f8", "<f16", "<c16", "<M8[s]", "|V8", "|S8", "<U8", "|b1", "<i8", "<u8"]
NAMES = ["../x", "/etc/x", "a/b", "", ".", "generation", "\0", "x" * 60_000, "\u202e", "state"]
TEXTS = ["", "[]", "{}", "[" * 3000, "5", '{"a": {}}', '[["a", "b", "c"]]', "\ud800", "1" * 5000]
NUMBERS = [-1, -(2**62), 2**62, 0, 7, 3.0, np.nan, np.inf, True, "3", b"3", [3], [[3, 3]], 3j]


def another_member(arrays, draw):
    name = draw.choice(NAMES)
    return zipped([*replaced(arrays), (f"{name}{draw.choice(['.npy', '', '.exe'])}", plain(1.0))])


def another_name(arrays, draw):
    members = replaced(arrays)
    k = draw.randrange(len(members))
    name = draw.choice([name for name in NAMES if f"{name}.npy" != members[k][0]])
    return zipped([*members[:k], (f"{name}.npy", members[k][1]), *members[k + 1 :]])


def one_less(arrays, draw):
    members = replaced(arrays)
    del members[draw.randrange(len(members))]
    return zipped(members)


def some_twice(arrays, draw):
    members = replaced(arrays)
    return zipped([*members, draw.choice(members)])


def another_header(arrays, draw):
    key = draw.choice([*arrays])
    data = np.asarray(arrays[key]).tobytes()
    return zipped(replaced(arrays, **{key: npy(0, 0, data, header=draw.choice(HEADERS))}))


def another_size(arrays, draw):
    key = draw.choice([key for key in arrays if np.size(arrays[key]) > 1])
    own = np.asarray(arrays[key])
    return zipped(replaced(arrays, **{key: npy(own.dtype.str, draw.choice(SHAPES), own.tobytes())}))


def another_type(arrays, draw):
    """Its bytes told to be of another type, or its numbers turned into it."""
    key = draw.choice(sorted(arrays.keys() - {"format", "made_by"}))
    own, descr = np.asarray(arrays[key]), draw.choice(TYPES)
    if own.dtype.str == descr or draw.random() < 0.3:
        told = draw.choice(["|O", [("a", "<f8"), ("b", "<i8")], ("<f8", (2,)), "<f4"])
        return zipped(replaced(arrays, **{key: npy(told, own.shape, own.tobytes())}))
    try:
        with np.errstate(all="ignore"):
            other = np.zeros(own.shape, descr) if descr == "|V8" else own.astype(descr)
    except (ValueError, TypeError):
        other = own.astype("O")
    data = other.dumps() if other.dtype == object else other.tobytes()
    return zipped(replaced(arrays, **{key: npy(descr, own.shape, data)}))


def another_shape(arrays, draw):
    key = draw.choice([key for key in arrays if np.ndim(arrays[key]) and np.size(arrays[key]) > 1])
    own = arrays[key]
    changes = [own[None], own[:-1], np.concatenate([own, own]), own[..., None], own[:0]]
    return zipped(replaced(arrays, **{key: draw.choice(changes)}))


def fewer_rows(arrays, draw):
    """In all arrays of a record, so that they agree."""
    group = draw.choice(["history.", "state.", "archive."])
    own = {k: v for k, v in arrays.items() if k.startswith(group) and np.ndim(v)}
    rows = draw.choice([slice(0), slice(1), slice(-1), slice(None, None, 2)])
    less = {key: array[rows] for key, array in own.items()}
    if all(len(less[key]) == len(own[key]) for key in own):
        return fewer_rows(arrays, draw)
    return zipped(replaced(arrays, **less))


def another_generation(arrays, draw):
    value = draw.choice(NUMBERS)
    done = int(arrays["generation"])
    return zipped(replaced(arrays, generation=np.array(value if value != done else -done)))


def another_value(arrays, draw):
    """One that no search has: not a number, or far out of its range."""
    chosen = [k for k in arrays if k.startswith(("archive.", "state."))]
    chosen = [k for k in chosen if not k.endswith(("damping", "median"))]
    key = draw.choice([*chosen, "history.best"])
    other = arrays[key].copy()
    places = np.argwhere(np.ones(other.shape)) if other.size else [()]
    place = tuple(draw.choice(list(places)))
    if other.dtype.kind == "f":
        if ".population." in key:  # of one that has not failed
            score = arrays[key.split(".population.")[0] + ".score"]
            alive = np.flatnonzero(np.isfinite(score))
            place = (draw.choice(list(alive)), *place[1:])
        other[place] = np.inf if key == "history.best" else draw.choice([np.nan, np.inf])
    else:
        other[place] = draw.choice([-1, 10**10, -(2**63), 2**63 - 1, 10**5])
    return zipped(replaced(arrays, **{key: other}))


def another_text(arrays, draw):
    key = draw.choice(["format", "made_by"])
    text = draw.choice(TEXTS)
    values = [np.array([text, text]), np.array(text), np.zeros(5), np.array(b"x"), np.arange(10**5)]
    value = draw.choice(values)
    try:
        return zipped(replaced(arrays, **{key: value}))
    except UnicodeEncodeError:
        return zipped(replaced(arrays, **{key: npy("<U1", (), b"\0\xd8\0\0")}))


def made_by_another(arrays, draw):
    told = json.loads(str(arrays["made_by"]))
    key = draw.choice([*told])
    other = draw.choice([{}, None, 5, "another", "\x1b[2J", [], "x" * 10**6])
    changed = {k: v for k, v in told.items() if k != key} if other is None else {**told, key: other}
    return zipped(replaced(arrays, made_by=np.array(json.dumps(changed))))


def compressed(arrays, draw):
    method = draw.choice([zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
    return zipped(replaced(arrays), method)


def bomb(arrays, draw):
    return _bomb(draw.choice([1, rounds(30, 300)]))


@cache
def _bomb(tens):
    """So many ten megabytes of zeros, a thousandth as long."""
    buffer = io.BytesIO()
    with (
        zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as file,
        file.open("generation.npy", "w", force_zip64=True) as member,
    ):
        member.write(npy("<f8", (tens * 10**7 // 8,), b""))
        for _ in range(tens):
            member.write(bytes(10**7))
    return with_digest(buffer.getvalue()[:-2] + b"\x40\x00" + bytes(64))


def crowd(arrays, draw):
    return zipped([(f"{k}.npy", b"") for k in range(draw.choice([2000, 30_000]))])


def lying_directory(arrays, draw):
    """Bits, sizes and places in the directory of the zip file, with a right digest."""
    content = bytearray(zipped(replaced(arrays)))
    start = content.index(b"PK\1\2")
    entries = [k for k in range(start, len(content)) if content[k : k + 4] == b"PK\1\2"]
    entry = draw.choice(entries)
    kind = draw.choice(["flag", "size", "both", "offset", "zip64", "overlap", "end", "crc", "name"])
    big = draw.choice([0xFFFFFFFF, 0x7FFFFFFF, 0, 1, 2**30]).to_bytes(4, "little")
    if kind == "flag":
        content[entry + 8] |= draw.choice([1, 0x20, 0x40])
    elif kind == "size":
        where = entry + draw.choice([20, 24])
        content[where : where + 4] = big
    elif kind == "both":
        content[entry + 20 : entry + 28] = 2 * big
    elif kind == "offset":
        content[entry + 42 : entry + 46] = big
    elif kind == "zip64":
        extra = b"\1\0\x10\0" + 2 * (2**60).to_bytes(8, "little")
        length = int.from_bytes(content[entry + 28 : entry + 30], "little")
        content[entry + 20 : entry + 28] = b"\xff" * 8
        content[entry + 30 : entry + 32] = len(extra).to_bytes(2, "little")
        content[entry + 46 + length : entry + 46 + length] = extra
        size = int.from_bytes(content[-74:-70], "little") + len(extra)
        content[-74:-70] = size.to_bytes(4, "little")
    elif kind == "overlap":
        other = draw.choice(entries)
        content[entry + 42 : entry + 46] = content[other + 42 : other + 46]
    elif kind == "end":
        content[-76:-72] = big
    elif kind == "crc":
        content[entry + 16 : entry + 20] = b"\0\1\2\3"
    else:
        content[entry + 28 : entry + 30] = draw.choice([b"\xff\xff", b"\0\0", b"\1\0"])
    return with_digest(bytes(content))


def flipped(arrays, draw):
    content = bytearray(zipped(replaced(arrays)))
    for _ in range(draw.choice([1, 3, 20])):
        content[draw.randrange(len(content) - 64)] ^= 1 << draw.randrange(8)
    return with_digest(bytes(content))


def broken(arrays, draw):
    return with_digest(damaged(zipped(replaced(arrays)), draw) + bytes(64))


def other_versions(arrays, draw):
    key = draw.choice([*arrays])
    own = np.asarray(arrays[key])
    version = draw.choice([b"\2\0", b"\3\0", b"\0\0", b"\1\1", b"\xff\xff"])
    found = npy(own.dtype.str, own.shape, own.tobytes(), version=version)
    return zipped(replaced(arrays, **{key: found}))


#: What every one of which has to be refused, and what may as well have changed nothing.
REFUSED = [another_member, another_name, one_less, some_twice, another_header, another_size]
REFUSED += [another_shape, fewer_rows, another_generation, another_value, another_text]
REFUSED += [made_by_another, compressed, bomb, crowd, other_versions]
EITHER = [another_type, lying_directory, flipped, broken]


@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_forged(base):
    draw, attack = drawn(base), Attack(f"crafted checkpoints: {base.name}")
    arrays = archive.unpacked(base.content)
    assert base.outcome(zipped(replaced(arrays))) == "undisturbed"
    forgers = [*REFUSED, *EITHER, *EITHER]
    for k in range(rounds(2 * len(forgers), 1000 // len(SEARCHES) + 1)):
        forger = forgers[k % len(forgers)]
        content = forger(arrays, draw)
        outcome = attack.input(base.outcome, content)
        assert outcome == "refused" or forger in EITHER, forger
    attack.end()


def test_columns_first(base):
    """NumPy writes so what lies so in memory."""
    arrays = archive.unpacked(base.content)
    turned = {
        key: npy(array.dtype.str, array.shape, array.tobytes("F"), order=True)
        for key, array in arrays.items()
    }
    assert base.outcome(zipped(replaced(turned))) == "undisturbed"


def test_what_is_no_file(base, tmp_path):
    """Nothing is read that does not end."""
    own = tmp_path / "run"
    shutil.copytree(base.folder, own)
    path = own / "checkpoint.npz"
    for make in (path.mkdir, lambda: path.symlink_to("/dev/zero"), lambda: _sparse(path)):
        path.unlink(missing_ok=True)
        make()
        with pytest.raises(UserError, match="is no file of at most"):
            design.run(design.opened_run(own), own)
        if path.is_dir() and not path.is_symlink():
            path.rmdir()


def _sparse(path):
    with path.open("wb") as file:
        file.truncate(2**40)


def test_the_headers_here_are_what_numpy_reads():
    """The forger's own writer makes arrays that are fine where it does not lie."""
    read = np.lib.format.read_array(io.BytesIO(plain([1.0, 2.0])))
    assert read.tolist() == [1.0, 2.0]
    assert ast.literal_eval(repr({"shape": (2,)})) == {"shape": (2,)}
