"""Files that scenarios and designs refer to by name, or contain as text."""

import json
from collections.abc import Callable
from contextlib import suppress
from hashlib import sha256
from os.path import exists, isdir, isfile
from pathlib import Path
from typing import Annotated, TypeAlias

from pydantic import AfterValidator, Discriminator, Field, PlainSerializer, Tag, ValidationInfo
from pydantic.functional_validators import model_validator

from hfc_design.core.numbers import Plain
from hfc_design.core.records import Record
from hfc_design.core.texts import LARGEST, LARGEST_TABLE, MEGABYTE, content

#: Largest number of characters of JSON for the files in a design, which may have ``LARGEST`` MB.
ROOM = LARGEST * MEGABYTE * 2 // 5


class EmbeddedFile(Record):
    """A file inside a record; without ``text`` it lies beside the record, and has this hash."""

    name: Annotated[str, Field(pattern=r"^[^/\\\x00-\x1f]{1,255}$")]  # of the file, without folder
    sha256: str  # hash of the bytes of the file
    text: str | None = None  # content of the file; left out: the file lies beside the record

    @model_validator(mode="after")
    def _is_whole(self) -> "EmbeddedFile":
        if self.text is not None and sha256(self.read_bytes()).hexdigest() != self.sha256:
            raise ValueError("sha256: does not match the text, which was changed")
        return self

    def __str__(self) -> str:
        return self.name

    @property
    def suffix(self) -> str:
        """Suffix of the name, like ``Path.suffix``."""
        return Path(self.name).suffix

    def read_bytes(self) -> bytes:
        """Return the text in UTF-8, like ``Path.read_bytes``; empty without ``text``."""
        return (self.text or "").encode()


AnyFile: TypeAlias = Path | EmbeddedFile
#: Type of a key for a file: a user writes a path, a design contains an ``EmbeddedFile``. In files
#: a path has "/", also on Windows.
WRITTEN = Annotated[
    Annotated[Path, Tag("path"), PlainSerializer(Path.as_posix, when_used="json")]
    | Annotated[EmbeddedFile, Tag("carried")],
    Discriminator(lambda one: "carried" if isinstance(one, dict | EmbeddedFile) else "path"),
]


def content_of(file: AnyFile, largest: int = LARGEST) -> bytes:
    """Return the bytes of a file; a path is read as by ``texts.content``, with its ValueError."""
    return file.read_bytes() if isinstance(file, EmbeddedFile) else content(file, largest)


def readable_by(read: Callable[[AnyFile], object]) -> AfterValidator:
    """Return a validator for a file that a record names: ``read`` must be able to read the file.

    Relative paths start at the ``folder`` of the validation context. ``read`` raises ValueError.
    """

    def located(file: AnyFile, info: ValidationInfo) -> AnyFile:
        if not isinstance(file, EmbeddedFile):
            return path_of(file, info)
        try:
            if file.text is None:
                path = path_of(file.name, info)
                if sha256(path.read_bytes()).hexdigest() != file.sha256:
                    raise ValueError("differs from the file that this was made with (sha256)")
                return path
            read(file)
        except ValueError as error:
            raise ValueError(f"name = {file.name!r}: {error}") from None
        return file

    def path_of(name: Path | str, info: ValidationInfo) -> Path:
        path = Path((info.context or {}).get("folder", "")) / name
        if exists(path) and not (isfile(path) or isdir(path)):
            raise ValueError("must be a regular file, which can be read twice")
        read(path)
        return path

    return AfterValidator(located)


def embedder(room: int = ROOM) -> Callable[[AnyFile], EmbeddedFile]:
    """Return a function that embeds one file after another, up to ``room`` characters in all.

    Of a file that does not fit, or is not text in UTF-8, it stores only name and hash.
    """
    left = room

    def carried(file: AnyFile) -> EmbeddedFile:
        nonlocal left
        whole = content_of(file, LARGEST_TABLE)
        named = EmbeddedFile(name=file.name, sha256=sha256(whole).hexdigest())
        try:
            text = whole.decode()
        except UnicodeDecodeError:
            return named
        needed = len(json.dumps(text))
        if needed > left:
            return named
        left -= needed
        return named.model_copy(update={"text": text})

    return carried


def embedded(part: Plain, folder: Path, carried: Callable[[AnyFile], EmbeddedFile]) -> Plain:
    """Return a part of a scenario with files of ``folder`` embedded in place of their names.

    Old designs contain only names. A name stays if its file cannot be read or does not fit.
    """
    if isinstance(part, list):
        return [embedded(one, folder, carried) for one in part]
    if not isinstance(part, dict):
        return part
    table = {key: embedded(one, folder, carried) for key, one in part.items()}
    file = table.get("file")
    if isinstance(file, str) and Path(file).name == file and isfile(folder / file):
        with suppress(ValueError):
            whole = carried(folder / file)
            table["file"] = whole.model_dump() if whole.text is not None else file
    return table
