"""Arrays by their names as one file: an .npz of NumPy that ends with a digest of itself.

Nothing that a file says of itself is believed before it has been compared with the file, so that
no file takes more memory than it is long, and none is ever unpickled.
"""

import io
import math
import zipfile
from hashlib import sha256

import numpy as np

Arrays = dict[str, np.ndarray]
#: Letters of the digest, which stands where a zip file has its comment.
DIGEST = 64
#: More arrays than this no search has.
MOST_MEMBERS = 1000
#: What an array may hold: truths, numbers of up to 64 bits or two of them, texts.
CODES = "?bBhHiIlLqQefdFDSU"
SUFFIX = ".npy"


def packed(arrays: Arrays) -> bytes:
    """The content of the file."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, array in arrays.items():
            with archive.open(name + SUFFIX, "w") as member:
                np.lib.format.write_array(member, array, allow_pickle=False)
    content = buffer.getvalue()[:-2] + DIGEST.to_bytes(2, "little")  # length of the comment
    return content + sha256(content).hexdigest().encode()


def is_whole(content: bytes) -> bool:
    """Whether the content is what ``packed`` gave, and not a bit is another."""
    return content[-DIGEST:] == sha256(content[:-DIGEST]).hexdigest().encode()


def unpacked(content: bytes) -> Arrays:
    """The arrays in the content of a file, with a digest or without.

    Raises:
        Exception: whatever ``zipfile`` and NumPy raise of what is none, and ValueError.
    """
    if content.count(b"PK\1\2") > MOST_MEMBERS:  # begins each entry in a zip file's directory
        raise ValueError(f"holds more than {MOST_MEMBERS} members")
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        members = archive.infolist()
        if len({member.filename for member in members}) < len(members):
            raise ValueError("holds a member twice")
        for member in members:
            if member.compress_type != zipfile.ZIP_STORED or member.flag_bits & 1:
                raise ValueError(f"member {member.filename[:60]!r} is compressed or encrypted")
            if not member.filename.endswith(SUFFIX):
                raise ValueError(f"member {member.filename[:60]!r} is no array")
        if sum(max(member.file_size, member.compress_size) for member in members) > len(content):
            raise ValueError("its members are larger than itself")
        return {x.filename.removesuffix(SUFFIX): _array(archive.read(x)) for x in members}


def _array(content: bytes) -> np.ndarray:
    stream = io.BytesIO(content)
    if np.lib.format.read_magic(stream) != (1, 0):
        raise ValueError("an array is of a format that is not written here")
    shape, _, dtype = np.lib.format.read_array_header_1_0(stream)
    if dtype.char not in CODES or not dtype.isnative or dtype.itemsize == 0:
        raise ValueError(f"an array of {str(dtype)[:60]} has no place here")
    size = len(content) - stream.tell()
    if min(shape, default=0) < 0 or math.prod(shape) * dtype.itemsize != size:
        raise ValueError("an array has not the size that it tells")
    found: np.ndarray = np.lib.format.read_array(io.BytesIO(content), allow_pickle=False)
    return found
