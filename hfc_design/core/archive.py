"""Named arrays in one file: an .npz of NumPy that ends with a digest of all bytes before it.

The sizes in a file's headers are checked before they are used, so that no file takes more memory
than its length. No content is ever unpickled.
"""

import io
import math
import warnings
import zipfile
from hashlib import sha256

import numpy as np

Arrays = dict[str, np.ndarray]
#: Characters of the digest, which stands where a zip file has its comment.
DIGEST = 64
#: Most arrays in a file; no search has more.
MOST_MEMBERS = 1000
#: Types of NumPy that an array may have: bools, numbers of 64 bits or complex ones of 128, texts.
CODES = "?bBhHiIlLqQefdFDSU"
SUFFIX = ".npy"
#: Version of an array's header -> its reader, which limits the length of a header.
HEADERS = {(1, 0): np.lib.format.read_array_header_1_0}


def packed(arrays: Arrays) -> bytes:
    """Return the content of a file with these arrays and the digest."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, array in arrays.items():
            with archive.open(name + SUFFIX, "w") as member:
                np.lib.format.write_array(member, array, allow_pickle=False)
    content = buffer.getvalue()[:-2] + DIGEST.to_bytes(2, "little")  # length of the comment
    return content + sha256(content).hexdigest().encode()


def is_whole(content: bytes) -> bool:
    """Return whether the content is unchanged since ``packed`` made it."""
    return content[-DIGEST:] == sha256(content[:-DIGEST]).hexdigest().encode()


def unpacked(content: bytes) -> Arrays:
    """Return the arrays in the content of a file, which need not have a digest.

    Raises:
        Exception: whatever ``zipfile`` and NumPy raise for other content, and ValueError.
    """
    if content.count(b"PK\1\2") > MOST_MEMBERS:  # begins each entry in a zip file's directory
        raise ValueError(f"holds more than {MOST_MEMBERS} members")
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        members = archive.infolist()
        if len({member.filename for member in members}) < len(members):
            raise ValueError("holds two members of one name")
        for member in members:
            if member.compress_type != zipfile.ZIP_STORED or member.flag_bits & 1:
                raise ValueError(f"member {member.filename[:60]!r} is encrypted or compressed")
            if not member.filename.endswith(SUFFIX):
                raise ValueError(f"member {member.filename[:60]!r} is not an array")
        if sum(max(member.file_size, member.compress_size) for member in members) > len(content):
            raise ValueError("its members are larger than the file")
        loaded = {}
        for member in members:
            with archive.open(member) as stream:  # read() without a size would unpack everything
                content = stream.read(member.file_size)
            loaded[member.filename.removesuffix(SUFFIX)] = array_of(content)
    for array in loaded.values():
        if array.dtype.char not in CODES or not array.dtype.isnative:
            raise ValueError(f"arrays of {str(array.dtype)[:60]} are not allowed")
    return {name: array.copy(order="K") for name, array in loaded.items()}


def array_of(content: bytes) -> np.ndarray:
    """Return the array in an .npy file without a copy; ValueError: it is damaged or has objects."""
    stream = io.BytesIO(content)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            shape, turned, dtype = HEADERS[np.lib.format.read_magic(stream)](stream)
    except Exception:  # of Python's parser, NumPy and codecs
        raise ValueError("the header of an array is damaged") from None
    if dtype.hasobject:
        raise ValueError("it holds Python objects, which are not read")
    count, size, begin = math.prod(shape), dtype.itemsize, stream.tell()
    odd = size == 0 or dtype.shape or min(shape, default=0) < 0
    if odd or count * size != len(content) - begin:
        raise ValueError("an array's size differs from its header")
    values = np.frombuffer(content, dtype, offset=begin) if count else np.zeros(0, dtype)
    return values.reshape(shape, order="F" if turned else "C")
