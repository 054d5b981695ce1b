"""Checkpoint of a search: written whole or not at all, read back bit for bit, never unpickled."""

import errno
import json
import os
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from hashlib import sha256
from pathlib import Path
from typing import Any, get_type_hints

import numpy as np

from hfc_design.core import archive
from hfc_design.core.lock import TEMPORARY, check, new_name
from hfc_design.core.numbers import Floats, Integers, Mask
from hfc_design.core.records import RunError, writing

FORMAT = "hfc-checkpoint-3"
#: Older formats, with the text of config.toml in place of ``made_by``. In the first one a failed
#: candidate has the score 0, and every other candidate a larger score.
EARLIER = "hfc-checkpoint-1", "hfc-checkpoint-2"
CONFIG = "config.toml"
#: Type of a field, a Python number or an array -> kinds (``dtype.kind``) that fit it.
NUMBERS = {bool: "b", int: "biu", float: "biuf"}
ARRAYS = {Floats: "f", Integers: "i", Mask: "b"}


def write_whole(path: Path, content: bytes) -> None:
    """Write a file so that a reader sees all of it or nothing, even after a power failure.

    Raises:
        RunError: the disk is full, the folder cannot be written, or it belongs to another process
            now; the old content stays.
    """
    temporary = new_name(path)
    with writing(path):
        file = temporary.open("xb")  # x: never a file or link that is there already
        try:
            with file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            check(path)
            _rename(temporary, path)
        except BaseException:
            with suppress(OSError):
                temporary.unlink()
            raise
        synced(path.parent)


def _rename(file: Path, path: Path) -> None:
    """Rename ``file`` to ``path``; on Windows wait a second for processes that read the old one."""
    for _ in range(10):
        with suppress(PermissionError):
            file.replace(path)
            return
        time.sleep(0.1)
    file.replace(path)


def synced(folder: Path) -> None:
    """Make sure that created and renamed files of a folder survive a power failure."""
    if not hasattr(os, "O_DIRECTORY"):  # Windows, which opens no folder
        return
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno != errno.EINVAL:  # a file system that cannot do this
            raise
    finally:
        os.close(descriptor)


def tidy(folder: Path) -> None:
    """Remove half-written files of killed processes; no other process may write into the folder."""
    for half in folder.glob("*".join(TEMPORARY)):
        with suppress(OSError):
            if half.is_dir() and not half.is_symlink():
                shutil.rmtree(half)
            else:
                half.unlink()


def save(path: Path, search: Any, made_by: dict[str, str]) -> None:
    """Write ``search``, a record of records and arrays, and ``made_by``, the versions that made it.

    Raises:
        RunError: it cannot be written.
    """
    header = {"format": np.array(FORMAT), "made_by": np.array(json.dumps(made_by))}
    write_whole(path, archive.packed({**header, **dict(flat(search))}))


@contextmanager
def corrupt_as_error(path: Path) -> Iterator[None]:
    """Turn any error of zipfile, NumPy and others about the file into a RunError: it is damaged."""
    try:
        yield
    except RunError:
        raise
    except Exception as error:
        raise RunError(
            f"{path}: is damaged or not a checkpoint ({error}); it was left unchanged"
        ) from None


def read(path: Path, largest: int) -> tuple[dict[str, str], archive.Arrays]:
    """Return ``made_by`` and the arrays of a search from a file of at most ``largest`` bytes.

    Raises:
        RunError: its format is unknown.
        Exception: it is damaged, too large or no file.
    """
    if not path.is_file() or path.stat().st_size > largest:
        raise ValueError(f"must be a file of at most {largest} bytes")
    content = path.read_bytes()
    arrays = archive.unpacked(content)
    version = str(arrays.pop("format"))
    if version == FORMAT:
        if not archive.is_whole(content):
            raise ValueError("its digest does not match")
        return dict(json.loads(str(arrays.pop("made_by")))), arrays
    if version not in EARLIER:
        raise RunError(f"{path}: is not a checkpoint of this version ({FORMAT})")
    if version == EARLIER[0]:
        scores = {key: array for key, array in arrays.items() if key.endswith(".score")}
        arrays |= {key: np.where(array == 0.0, -np.inf, array) for key, array in scores.items()}
    return {CONFIG: digest(str(arrays.pop("config")).encode())}, arrays


def record_of(kind: type, fields: dict[Any, Any], arrays: archive.Arrays) -> Any:
    """Return the arrays as a record of the class ``kind``, whose fields may be records.

    ``fields``: name or annotation of a field -> its type, or a record of the same structure.

    Raises:
        ValueError, KeyError: an array does not fit such a record, is missing or is unknown.
    """
    left = dict(arrays)
    record = _built(kind, "", left, fields)
    if left:
        raise ValueError(f"holds an unexpected {next(iter(left))!r}")
    return record


def digest(content: bytes) -> str:
    """Return the SHA-256 digest of a content."""
    return sha256(content).hexdigest()


def _named(record: tuple[Any, ...]) -> dict[str, Any]:
    """Return name -> field of a record, or index (as text) -> element of a tuple."""
    names = getattr(record, "_fields", map(str, range(len(record))))
    return dict(zip(names, record, strict=True))


def flat(record: Any, prefix: str = "") -> list[tuple[str, np.ndarray]]:
    """Return (name, array) of every array of a record of records, as "population.tree"."""
    if not isinstance(record, tuple):
        return [(prefix.rstrip("."), np.asarray(record))]
    parts = _named(record).items()
    return [item for name, part in parts for item in flat(part, f"{prefix}{name}.")]


def _built(like: Any, prefix: str, arrays: dict[str, np.ndarray], known: dict[Any, Any]) -> Any:
    """Build an object from ``arrays``: of the type ``like``, or structured like that record."""
    if isinstance(like, tuple):
        kind, parts = type(like), _named(like)
    elif hasattr(like, "_fields"):
        hints = get_type_hints(like).items()
        kind, parts = like, {key: known.get(key, known.get(hint, hint)) for key, hint in hints}
    else:
        name, is_number = prefix.rstrip("."), isinstance(like, type) and like in NUMBERS
        # With another memory order, products of matrices would round in another way.
        value = np.asarray(arrays.pop(name), order="C")
        if not _fits(value, like):
            raise ValueError(f"{name} does not belong to such a search")
        return like(value) if is_number else value
    values = [_built(part, f"{prefix}{key}.", arrays, known) for key, part in parts.items()]
    return kind(*values) if hasattr(kind, "_fields") else tuple(values)


def _fits(value: np.ndarray, like: Any) -> bool:
    """Return whether a value has the type ``like``, or elements as those of the array ``like``."""
    if isinstance(like, np.ndarray):
        same = value.ndim == like.ndim and value.shape[1:] == like.shape[1:]
        real = value.dtype.kind in NUMBERS[float]
        return same and real and np.can_cast(like.dtype, value.dtype, "same_kind")
    if like in NUMBERS:
        return value.shape == () and value.dtype.kind in NUMBERS[like]
    return like not in ARRAYS or value.dtype.kind in ARRAYS[like]
