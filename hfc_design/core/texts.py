"""Reading of users' files: within limits, and only what can be processed and written again.

A mistake in a text raises a ``ValueError`` that does not name the file, because the text may be a
part of another file. ``as_user_error`` turns the error into a line for the user.
"""

import codecs
import io
import json
import os
import re
import tomllib
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from difflib import get_close_matches
from math import isfinite
from os.path import realpath
from pathlib import Path
from typing import NoReturn

from pydantic import AfterValidator

from hfc_design.core.numbers import Json, Plain
from hfc_design.core.records import UserError
from hfc_design.core.wording import one_of

MEGABYTE = 1_000_000
#: Largest size of a text, and of a table of numbers [MB].
LARGEST, LARGEST_TABLE = 5, 64
#: Most levels of nested tables and lists, and most parts of a dotted key.
DEEPEST = 64
NESTED = f"lists and tables are nested more than {DEEPEST} deep"
#: First bytes of a compressed file -> name of the compression.
PACKED = {b"\x1f\x8b": "gzip", b"\xfd7zXZ": "xz", b"BZh": "bzip2", b"PK": "zip", b"(\xb5": "zstd"}
# tomllib takes a time that grows with the square of a key's parts; these pass each part once.
_STRING = re.compile(r"\"(?:[^\"\\]|\\.)*+\"?|'[^']*+'?")
_LONG_KEY = re.compile(rf"(?<![\w-])(?:[\w-]++[ \t]*+\.[ \t]*+){{{DEEPEST}}}")


def content(path: str | Path, largest: int = LARGEST) -> bytes:
    """Return the bytes of a file, of a pipe from the shell or of a device, at most ``largest`` MB.

    Raises:
        ValueError: it cannot be read, has more, or is a named pipe, whose writer may never come.
    """
    try:
        if Path(realpath(path)).is_fifo():  # False for a pipe from the shell, which has no path
            raise OSError("it is a named pipe; give a file, or /dev/stdin")
        with open(path, "rb") as file:
            much = os.fstat(file.fileno()).st_size > largest * MEGABYTE
            data = b"" if much else file.read(largest * MEGABYTE + 1)
    except (OSError, ValueError) as error:  # ValueError: a zero byte in the name
        reason = getattr(error, "strerror", None) or error
        raise ValueError(f"cannot be read: {reason}") from None
    if much or len(data) > largest * MEGABYTE:
        raise ValueError(f"cannot be read: it has more than {largest} MB")
    return data


def decoded(data: bytes, encoding: str = "utf-8", errors: str = "strict") -> str:
    """Return the text in a file's bytes (UTF-16 if marked so); ValueError: no text, compressed."""
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        encoding = "utf-16"
    try:
        return io.TextIOWrapper(io.BytesIO(data), encoding).read()  # a line ends with \n
    except UnicodeDecodeError:
        for start, packer in PACKED.items():
            if data.startswith(start):
                raise ValueError(f"cannot be read: it is packed by {packer}; unpack it") from None
        if errors == "strict":
            advice = "save it in that encoding, or convert it: iconv -f cp1252 -t utf-8"
            raise ValueError(f"cannot be read: it is not UTF-8 text; {advice}") from None
    return io.TextIOWrapper(io.BytesIO(data), encoding, errors).read()


def toml_of(text: str) -> Json:
    """Content of a TOML text; ValueError: it is not TOML, or goes beyond the limits."""
    for line in text.split("\n"):
        if line.count(".") >= DEEPEST and _LONG_KEY.search(_STRING.sub("_", line)):
            raise ValueError(f"is not valid TOML: a key has more than {DEEPEST} parts")
    try:
        return _parsed("is not valid TOML", tomllib.loads, text)
    except ValueError as error:
        raise ValueError(f"{error}{_hint(str(error), text)}") from None


#: Patterns: the line number in an error of tomllib; a number with a decimal comma.
_WHERE, _COMMA = re.compile(r"\(at line (\d{1,9})"), re.compile(r"=\s*([-+]?\d+),(\d+)\s*(#.*)?$")
_TWICE = "Cannot overwrite a value"


def _hint(message: str, text: str) -> str:
    """Return the end of a message with the likely cause of a mistake in TOML; "": not known."""
    lines, match = text.rstrip().split("\n"), _WHERE.search(message)
    line = lines[min(int(match[1]) if match else len(lines), len(lines)) - 1]
    if comma := _COMMA.search(line):
        return f"; write numbers with a decimal point: {comma[1]}.{comma[2]}"
    return f"; {line.partition('=')[0].strip()[:60]} is given twice" if _TWICE in message else ""


def json_of(text: str) -> Plain:
    """Content of a JSON text; ValueError: it is not JSON, or goes beyond the limits."""
    return _parsed("is not valid JSON", JSON.decode, text, finite=True)


def _parsed(wrong: str, parse: Callable[[str], Plain], text: str, finite: bool = False) -> Plain:
    try:
        parsed = parse(text)
        fault = plain_fault(parsed, finite)
    except RecursionError:
        fault = NESTED
    except ValueError as error:
        fault = str(error).partition("; use sys.")[0]  # the rest is for programmers
    if fault:
        raise ValueError(f"{wrong}: {fault}")
    return parsed


def _no_number(name: str) -> NoReturn:
    raise ValueError(f"{name} is not a number that a design may hold")


def _distinct(pairs: list[tuple[str, Plain]]) -> Json:
    table = dict(pairs)
    if len(table) < len(pairs):
        twice, _ = Counter(key for key, _ in pairs).most_common(1)[0]
        raise ValueError(f"the key {twice[:60]!r} is given twice in a table")
    return table


JSON = json.JSONDecoder(parse_constant=_no_number, object_pairs_hook=_distinct)


def plain_fault(value: Plain, finite: bool = False) -> str | None:
    """Reason why a value from TOML or JSON cannot be used or written again; None if it can."""
    level = [value]
    for _ in range(DEEPEST + 1):
        inside: list[Plain] = []
        for item in level:
            if isinstance(item, dict):
                inside += [*item, *item.values()]
            elif type(item) in (list, tuple):
                inside += item
            elif isinstance(item, str) and not item.isascii():
                try:
                    item.encode()
                except UnicodeEncodeError:
                    half = "half a character (a surrogate), which UTF-8 cannot encode"
                    return f"a string holds {half}"
            elif isinstance(item, int) and item.bit_length() > 1023:
                return "an integer is larger than any float"
            elif finite and isinstance(item, float) and not isfinite(item):
                return f"{item} is not a number that a file may hold"
        if not inside:
            return None
        level = inside
    return NESTED


@AfterValidator
def writable(data: Json) -> Json:
    """Validate a part of a file that is kept as it is: it must be possible to write it again."""
    if fault := plain_fault(data, finite=True):
        raise ValueError(fault)
    return data


@contextmanager
def as_user_error(source: object) -> Iterator[None]:
    """Turn a ValueError about a text into a UserError that names the ``source`` of the text."""
    try:
        yield
    except ValueError as error:
        raise UserError(f"{source}: {error}") from None


def read_text(path: str | Path) -> str:
    """Content of a user's file, in UTF-8; UserError: it cannot be read."""
    with as_user_error(path):
        return decoded(content(path))


def read_toml(path: str | Path) -> Json:
    """Content of a user's TOML file; UserError: it cannot be read, or is not TOML."""
    with as_user_error(path):
        return toml_of(decoded(content(path)))


def read_json(path: str | Path, largest: int = LARGEST) -> Plain:
    """Content of a JSON file of up to ``largest`` MB; UserError: cannot be read, or is no JSON."""
    with as_user_error(path):
        return json_of(decoded(content(path, largest)))


#: Kind of file -> its suffix, and its name in messages.
FILES = {"scenario": (".toml", "a TOML file"), "design": (".json", "a design file")}


def no_such(what: str, name: str, built_in: Iterable[str]) -> UserError:
    """Error for a scenario or design that does not exist; it suggests a similar name."""
    ending, file = FILES[what]
    try:
        there = [Path(x) for x in sorted(os.listdir(Path(name).parent)) if x != Path(name).name]
    except (OSError, ValueError):  # ValueError: a zero byte in the name
        there = []
    stems = {path.stem: path.name for path in there if path.suffix == ending}
    known, stem = [*built_in], Path(name).name.removesuffix(ending)
    for near in get_close_matches(stem, [*known, *stems], 1):
        if near not in known:
            meant = Path(name).with_name(stems[near])
            return UserError(f"{name}: no such file or {what}; did you mean {meant}?")
    known_as = what if Path(name).suffix in ("", ending) else f"file or {what}"
    return UserError(
        f"{name}: no such {known_as}; {one_of(stem, known, 'built in:')}, or give {file}"
    )
