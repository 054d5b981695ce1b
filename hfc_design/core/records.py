"""Checked records of what a user wrote, and the one-line messages about what is wrong with it."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError

from hfc_design.core.numbers import Plain

Finite = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
NAME = r"^[A-Za-z0-9][A-Za-z0-9._-]{0,63}$"
Name = Annotated[str, Field(pattern=NAME)]
Label = Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]{0,31}$")]

#: Linguistic terms of an input; a rule table is TERMS x TERMS.
TERMS = 7
ZR = TERMS // 2  # place of the middle term
Row = Annotated[tuple[Finite, ...], Field(min_length=TERMS, max_length=TERMS)]
Table = Annotated[tuple[Row, ...], Field(min_length=TERMS, max_length=TERMS)]


@AfterValidator
def ordered(pair: tuple[float, float]) -> tuple[float, float]:
    """Validates a range."""
    if pair[0] > pair[1]:
        raise ValueError("has to be [low, high]")
    return pair


class Record(BaseModel):
    """An immutable record; unknown keys are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True)


#: Characters of a message: nobody reads more.
LONGEST = 360


def in_a_line(message: str) -> str:
    """A message as a line, whatever was quoted in it: not long, and nothing moves the terminal."""
    line = " ".join(message.split())
    if len(line) > LONGEST:  # who is meant stands in front, what is allowed at the end
        line = f"{line[: LONGEST - 100]} ... {line[-95:]}"
    return harmless(line)


def harmless(text: str) -> str:
    """A text of which nothing moves the terminal."""
    return "".join(letter if letter.isprintable() else "?" for letter in text)


class UserError(Exception):
    """Something that the user wrote cannot be used: exit code 2."""

    exit_code = 2

    def __str__(self) -> str:
        return in_a_line(str(self.args[0]))  # whoever says where it was has room before


class RunError(UserError):
    """Something outside the program went wrong, a full disk for one: exit code 1."""

    exit_code = 1


@contextmanager
def writing(place: Path) -> Iterator[None]:
    """What the system refuses becomes a RunError that names the file or folder to be written."""
    try:
        yield
    except OSError as error:
        raise RunError(f"{place}: cannot be written: {error.strerror or error}") from None


Checked = TypeVar("Checked", bound=BaseModel)


def checked(
    model: type[Checked], data: Plain, source: str | Path, folder: Path, **context: Any
) -> Checked:
    """``data`` of the file ``source`` as a record; a file that it names lies in ``folder``.

    ``context`` is for the validators.

    Raises:
        UserError: data is not what the model allows; one line with file, key, value and rule.
    """
    try:
        return model.model_validate(data, context={"folder": folder, **context})
    except ValidationError as error:
        raise UserError(f"{source}: {_explained(error, data)}") from None
    except ArithmeticError as error:  # of what is computed to check it
        told = "a number in it is too large or too small to compute with"
        raise UserError(f"{source}: {told} ({error})") from None


#: Kind of a mistake -> what TOML and JSON call what is wanted.
PLAIN = {
    **dict.fromkeys(("tuple_type", "list_type"), "has to be a list"),
    **dict.fromkeys(("dict_type", "model_type"), "has to be a table of keys and values"),
    "callable_type": "has to be a function",
    "extra_forbidden": "there is no such key",
}
#: The same of lists and tables of another length -> what bounds it, and how that is said.
LENGTHS = {"too_short": ("min_length", "at least"), "too_long": ("max_length", "at most")}


def _explained(error: ValidationError, data: Plain) -> str:
    first, *others = error.errors()
    missing = first["type"] == "missing"
    keys, value = _place(first["loc"], data, missing)
    message = PLAIN.get(first["type"], first["msg"].removeprefix("Value error, "))
    if first["type"] in LENGTHS:
        bound, words = LENGTHS[first["type"]]
        counts = first["ctx"]
        message = f"has to have {words} {counts[bound]} entries, not {counts['actual_length']}"
    if missing:
        # whoever begins a file wants to know all of them at once
        lack = [other for other in (first, *others) if other["type"] == "missing"]
        others = [other for other in others if other["type"] != "missing"]
        names = [_place(other["loc"], data, missing)[0] for other in lack]
        message = f"{', '.join(names)}: {'are' if len(names) > 1 else 'is'} missing"
    elif first["type"] == "value_error" and isinstance(value, dict):
        message = f"{keys}.{message}" if keys else message  # the record names its own key
    elif keys:
        message = f"{keys} = {short(value)}: {message}"
    return f"{message} (and {len(others)} more)" if others else message


def _place(location: tuple[int | str, ...], data: Plain, missing: bool) -> tuple[str, Plain]:
    """The dotted key of a location, the last one perhaps missing, and what stands there.

    pydantic puts the branch of a union into the location too; no such key is in the file.
    """
    keys = []
    for k, part in enumerate(location):
        last = k + 1 == len(location)
        branch = part not in data if isinstance(data, dict) else not isinstance(data, list | tuple)
        if branch and not (last and missing):
            continue
        keys.append(str(part))
        try:
            data = data[part]
        except (KeyError, IndexError, TypeError):
            data = None
    return ".".join(keys), data


def short(value: Plain, limit: int = 60) -> str:
    """A value in a message."""
    text = repr(value)
    return text if len(text) <= limit else text[:limit] + "..."
