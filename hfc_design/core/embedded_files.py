"""Files that a record names, or contains so that it works without them."""

import json
from collections.abc import Callable
from contextlib import suppress
from hashlib import sha256
from os.path import exists, isdir, isfile
from pathlib import Path
from typing import Annotated, TypeAlias

from pydantic import AfterValidator, Discriminator, Field, Tag, ValidationInfo, model_validator

from hfc_design.core.numbers import Plain
from hfc_design.core.records import Record
from hfc_design.core.texts import LARGEST, LARGEST_TABLE, MEGABYTE, content

#: Letters of JSON that a design has for the files that it carries; it is read up to ``LARGEST``.
ROOM = LARGEST * MEGABYTE * 2 // 5


class EmbeddedFile(Record):
    """A file within another; without ``text`` it lies beside that one, identified by its hash."""

    name: Annotated[str, Field(pattern=r"^[^/\\\x00-\x1f]{1,255}$")]  # of the file
    sha256: str  # of its bytes
    text: str | None = None  # what it holds; left out: it lies beside, with this hash

    @model_validator(mode="after")
    def _is_whole(self) -> "EmbeddedFile":
        if self.text is not None and sha256(self.read_bytes()).hexdigest() != self.sha256:
            raise ValueError("sha256: does not match the text, which was changed")
        return self

    def __str__(self) -> str:
        return self.name

    @property
    def suffix(self) -> str:
        """Suffix, as of a path."""
        return Path(self.name).suffix

    def read_bytes(self) -> bytes:
        """Content, as of a path."""
        return (self.text or "").encode()


AnyFile: TypeAlias = Path | EmbeddedFile
#: How a user writes one, and how a design does.
WRITTEN = Annotated[
    Annotated[Path, Tag("path")] | Annotated[EmbeddedFile, Tag("carried")],
    Discriminator(lambda one: "carried" if isinstance(one, dict | EmbeddedFile) else "path"),
]


def content_of(file: AnyFile, largest: int = LARGEST) -> bytes:
    """Content of a file; ValueError as from ``texts.content``."""
    return file.read_bytes() if isinstance(file, EmbeddedFile) else content(file, largest)


def readable_by(read: Callable[[AnyFile], object]) -> AfterValidator:
    """Validator of a file named in another: reads it, with relative paths from that file's folder.

    ``read`` raises ValueError if it cannot be read.
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
    """Function that embeds one file after another, as long as there is ``room``.

    A file that does not fit, or is not text in UTF-8, stays beside the record.
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
    """Part of a scenario as a design stores it, with the files in ``folder`` that it only names.

    Earlier designs contain only the name; a file that cannot be read stays a name.
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
