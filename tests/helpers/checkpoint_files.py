"""Checkpoints as files: how one is spelled, how it is damaged, and zip files that lie.

Each forger gives a whole file of the arrays of a checkpoint, with a right digest.
"""

import io
import zipfile
from functools import cache
from hashlib import sha256

import numpy as np
from attack import rounds


def with_digest(content):
    """A zip file whose digest is right, whatever is in it."""
    return content[:-64] + sha256(content[:-64]).hexdigest().encode()


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


#: Those of which every file has to be refused, and those that may as well change nothing.
REFUSED = [compressed, bomb, crowd, other_versions]
EITHER = [lying_directory, flipped, broken]
