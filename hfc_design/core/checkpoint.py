"""A search on disk: written whole or not at all, read back bit for bit, never unpickled."""

import io
import os
import zipfile
import zlib
from pathlib import Path
from typing import Any, get_type_hints

import numpy as np

from hfc_design.core.records import RunError, UserError

FORMAT = "hfc-checkpoint-2"
#: In which what had failed scored 0, and everything else more.
FIRST_FORMAT = "hfc-checkpoint-1"


def write_whole(path: Path, content: bytes) -> None:
    """Write a file so that a reader, or a machine that lost power, sees all of it or nothing.

    Raises:
        RunError: the disk is full or the folder cannot be written; what was there stays.
    """
    beside = path.with_name(path.name + ".new")
    try:
        with beside.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        beside.replace(path)
    except OSError as error:
        raise RunError(f"{path}: cannot be written: {error.strerror or error}") from None


def save(path: Path, search: Any, config: str) -> None:
    """Write ``search``, a record of records and arrays, for the run with this config.

    Raises:
        RunError: it cannot be written.
    """
    arrays = {"format": np.array(FORMAT), "config": np.array(config), **dict(_flat(search))}
    buffer = io.BytesIO()
    np.savez(buffer, allow_pickle=False, **arrays)
    write_whole(path, buffer.getvalue())


def load(path: Path, kind: type, fields: dict[Any, Any], config: str) -> Any:
    """The search of type ``kind`` in ``path``.

    ``fields`` has, of some fields in it by their name or annotation, the type, or one that is
    built like them.

    Raises:
        RunError: the file is damaged, is no checkpoint, or belongs to another run.
    """
    try:
        with np.load(io.BytesIO(path.read_bytes()), allow_pickle=False) as stored:
            arrays = {name: stored[name] for name in stored.files}
        if str(arrays["format"]) == FIRST_FORMAT:
            scores = {key: array for key, array in arrays.items() if key.endswith(".score")}
            arrays |= {key: np.where(array == 0.0, -np.inf, array) for key, array in scores.items()}
        elif str(arrays["format"]) != FORMAT:
            raise RunError(f"{path}: is not a checkpoint of this version ({FORMAT})")
        if str(arrays["config"]) != config:
            raise RunError(f"{path}: belongs to a run with another config.toml")
        return _built(kind, "", arrays, fields)
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error) as error:
        raise RunError(f"{path}: is damaged or no checkpoint; left as it is ({error})") from None


def _flat(record: Any, prefix: str = "") -> list[tuple[str, np.ndarray]]:
    if isinstance(record, tuple):
        names = getattr(record, "_fields", map(str, range(len(record))))
        parts = zip(names, record, strict=True)
        return [item for name, part in parts for item in _flat(part, f"{prefix}{name}.")]
    return [(prefix.rstrip("."), np.asarray(record))]


def _built(kind: Any, prefix: str, arrays: dict[str, np.ndarray], known: dict[Any, Any]) -> Any:
    if isinstance(kind, tuple):
        return _like(kind, prefix, arrays)
    if hasattr(kind, "_fields"):
        hints = {k: known.get(k, known.get(own, own)) for k, own in get_type_hints(kind).items()}
        parts = (_built(hints[name], f"{prefix}{name}.", arrays, known) for name in kind._fields)
        return kind(*parts)
    value = arrays[prefix.rstrip(".")]
    return kind(value) if kind in (int, float, bool) else value


def _like(record: Any, prefix: str, arrays: dict[str, np.ndarray]) -> Any:
    """What is built like ``record``, tuples of tuples of arrays."""
    if not isinstance(record, tuple):
        return arrays[prefix.rstrip(".")]
    names = getattr(record, "_fields", map(str, range(len(record))))
    parts = [
        _like(part, f"{prefix}{name}.", arrays) for name, part in zip(names, record, strict=True)
    ]
    return type(record)(*parts) if hasattr(record, "_fields") else tuple(parts)


def read_text(path: str | Path) -> str:
    """What a user's file says, in UTF-8.

    Raises:
        UserError: it cannot be read.
    """
    try:
        return Path(path).read_text(encoding="utf-8")
    except OSError as error:
        raise UserError(f"{path}: cannot be read: {error.strerror or error}") from None
    except UnicodeDecodeError:
        raise UserError(f"{path}: cannot be read: it is not a text in UTF-8") from None
