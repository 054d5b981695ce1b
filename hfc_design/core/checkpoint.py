"""A search on disk: written whole or not at all, read back bit for bit, never unpickled."""

import io
import os
import tomllib
import zipfile
import zlib
from pathlib import Path
from typing import Any, get_type_hints

import numpy as np

from hfc_design.core.lock import Overtaken, check
from hfc_design.core.numbers import Json
from hfc_design.core.records import RunError, UserError

FORMAT = "hfc-checkpoint-2"
#: In which what had failed scored 0, and everything else more.
FIRST_FORMAT = "hfc-checkpoint-1"


def write_whole(path: Path, content: bytes) -> None:
    """Write a file so that a reader, or a machine that lost power, sees all of it or nothing.

    Raises:
        RunError: the disk is full, the folder cannot be written, or it belongs to another process
            now; what was there stays.
    """
    beside = path.with_name(path.name + ".new")
    try:
        with beside.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        check(path)
        beside.replace(path)
    except Overtaken:
        beside.unlink(missing_ok=True)
        raise
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


def _named(record: tuple[Any, ...]) -> dict[str, Any]:
    """The parts of a record, or of a tuple by their numbers."""
    names = getattr(record, "_fields", map(str, range(len(record))))
    return dict(zip(names, record, strict=True))


def _flat(record: Any, prefix: str = "") -> list[tuple[str, np.ndarray]]:
    if not isinstance(record, tuple):
        return [(prefix.rstrip("."), np.asarray(record))]
    parts = _named(record).items()
    return [item for name, part in parts for item in _flat(part, f"{prefix}{name}.")]


def _built(like: Any, prefix: str, arrays: dict[str, np.ndarray], known: dict[Any, Any]) -> Any:
    """What is of the type ``like``, or built like that record: tuples of tuples of arrays."""
    if isinstance(like, tuple):
        kind, parts = type(like), _named(like)
    elif hasattr(like, "_fields"):
        hints = get_type_hints(like).items()
        kind, parts = like, {key: known.get(key, known.get(own, own)) for key, own in hints}
    else:
        value = arrays[prefix.rstrip(".")]
        return like(value) if any(like is kind for kind in (int, float, bool)) else value
    found = [_built(part, f"{prefix}{key}.", arrays, known) for key, part in parts.items()]
    return kind(*found) if hasattr(kind, "_fields") else tuple(found)


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


def read_toml(path: Path) -> Json:
    """What a user's TOML file says.

    Raises:
        UserError: it cannot be read, or is no TOML.
    """
    try:
        return tomllib.loads(read_text(path))
    except tomllib.TOMLDecodeError as error:
        raise UserError(f"{path}: is not valid TOML: {error}") from None
