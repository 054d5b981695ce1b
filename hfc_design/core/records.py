"""Records that check user input, and errors with a line for each mistake in it."""

import re
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from numbers import Number
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self, TypeAlias, TypeVar, get_args

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ModelWrapValidatorHandler,
    SerializerFunctionWrapHandler,
    ValidationError,
    model_serializer,
    model_validator,
)
from pydantic_core import PydanticKnownError

from hfc_design.core import quantities
from hfc_design.core.numbers import Plain
from hfc_design.core.validation_errors import NO_KEYS, format_errors, with_keys
from hfc_design.core.wording import Keys


def _no_number(value: Plain) -> bool:
    """Return whether a value is a bool or a text like "1_0", which Python takes for 1 and 10."""
    return isinstance(value, bool) or (isinstance(value, str) and "_" in value)


@BeforeValidator
def _no_truth(value: Plain) -> Plain:
    """Validate a number: bools and texts like "1_0" are not numbers."""
    if _no_number(value):
        raise PydanticKnownError("float_type")
    return value


Finite = Annotated[float, Field(allow_inf_nan=False), _no_truth]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False), _no_truth]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False), _no_truth]
#: A number in the unit of the drive, or a text with a number and a unit, as "20 urad".
Quantity: TypeAlias = Annotated[Finite | str, AfterValidator(quantities.known)]
NAME = r"^[A-Za-z0-9][A-Za-z0-9._-]{0,63}$"
Name = Annotated[str, Field(pattern=NAME)]
Label = Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]{0,31}$")]

#: Number of linguistic terms of an input; a rule table has TERMS x TERMS numbers.
TERMS = 7
ZR = TERMS // 2  # index of the middle term, zero
Row = Annotated[tuple[Finite, ...], Field(min_length=TERMS, max_length=TERMS)]
Rules = Annotated[tuple[Row, ...], Field(min_length=TERMS, max_length=TERMS)]


@AfterValidator
def ordered(pair: tuple[float, float]) -> tuple[float, float]:
    """Validate a range: the lower bound comes first."""
    if pair[0] > pair[1]:
        raise ValueError("must be [low, high]")
    return pair


class Asked(type(BaseModel)):  # type: ignore[misc]
    """Metaclass of records that scripts create: a mistake gives the same line as in a file."""

    def __call__(cls, *given: Any, **fields: Any) -> Any:
        """Create a record; UserError: a value is not allowed."""
        try:
            return super().__call__(*given, **fields)
        except ValidationError as error:
            again = cls.model_validate
            raise UserError(*format_errors(error, fields, again)).within(cls.__name__) from None


class Record(BaseModel):
    """An immutable record; unknown keys are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    @model_validator(mode="wrap")
    @classmethod
    def _tells_its_keys(cls, data: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        try:
            return handler(cls._without_truths(data))
        except ValidationError as error:
            raise with_keys(error, cls) from None

    @classmethod
    def _without_truths(cls, data: Any) -> Any:
        """Return ``data`` with ``...``, which is refused, for bools and "1_0" in number fields."""
        if not isinstance(data, dict) or not any(map(_no_number, data.values())):
            return data
        kinds = {name: one.annotation for name, one in cls.model_fields.items()}
        numbers = {
            name
            for name, x in kinds.items()
            if {x, *get_args(x), *map(type, get_args(x))} & {int, float}  # of Literal[0, 1] too
        }
        wrong = {key for key, x in data.items() if _no_number(x) and key in numbers}
        return data | dict.fromkeys(wrong, ...)


class Ordered(Record):
    """A record stored with ``keys_last`` at the end: cells of batches are named by this text."""

    keys_last: ClassVar[Collection[str]] = ()

    @model_serializer(mode="wrap")
    def _in_order(self, whole: SerializerFunctionWrapHandler) -> dict[str, Any]:
        data: dict[str, Any] = whole(self)
        return {key: data[key] for key in sorted(data, key=lambda key: key in self.keys_last)}


#: Marks around the two wordings of a text: noncharacters of Unicode, which no shown text contains.
BEGIN, OR, END = MARKS = "\ufdd0\ufdd1\ufdd2"
_BOTH = re.compile(f"{BEGIN}([^{MARKS}]*){OR}([^{MARKS}]*){END}")
NOTHING: Any = object()


def either(typed: str, in_script: str) -> str:
    """Return a text for messages that reads ``typed`` on the command line, else ``in_script``."""
    return BEGIN + OR.join(re.sub(f"[{MARKS}]", "?", text) for text in (typed, in_script)) + END


def option(name: str, value: Any = NOTHING, argument: str = "", key: str | None = None) -> str:
    """Return an option as messages name it: ``--name``, in scripts the ``argument`` of a function.

    In ``name``, ``_`` stands for ``-``; ``argument`` is "" if it equals ``name``. ``value`` is what
    the user gave: True for an option without a value, ``...`` if the value is still missing.
    ``key`` is the key of ``value`` in a mapping; without ``value``, one of several given texts.
    """
    typed, in_script = f"--{name.replace('_', '-')}", argument or name
    shown = str(value) if isinstance(value, Number) else repr(value)
    if value is ... or value is True:
        return either(typed, f"{in_script}={'' if value is ... else value}")
    if key is None:
        nothing = value is NOTHING
        return (
            either(typed, in_script)
            if nothing
            else either(f"{typed} {value}", f"{in_script}={shown}")
        )
    if value is NOTHING:
        return either(f"{typed} {key}", f"{in_script}: {key}")
    return either(f"{typed} {key}={value}", f"{in_script}={{{key!r}: {shown}}}")


#: Most characters of a line of a message, without "hfc: " before it.
LONGEST = 295
#: A long path or value; in a line that is too long only its beginning and its end are shown.
LONG_WORD = re.compile(r"\S{101,}")


def in_a_line(message: str, to_script: bool = False) -> str:
    """Return a message as a printable line of limited length; ``to_script``: worded for scripts."""
    line = " ".join(_BOTH.sub(r"\2" if to_script else r"\1", message).split())
    if len(line) > LONGEST:
        line = LONG_WORD.sub(lambda match: f"{match[0][:60]}...{match[0][-30:]}", line)
    if len(line) > LONGEST:  # it begins with what is wrong, and ends with what is allowed
        line = f"{line[: LONGEST - 100]} ... {line[-95:]}"
    return harmless(line)


def harmless(text: str) -> str:
    """Return a text with "?" in place of characters that may control the terminal."""
    return "".join(letter if letter.isprintable() else "?" for letter in text)


class UserError(Exception):
    """Error in user input; ``args`` has a line for each mistake; the exit code is 2."""

    exit_code = 2

    @property
    def lines(self) -> list[str]:
        """A printable line for each mistake, worded for the command line."""
        return [in_a_line(str(line)) for line in self.args]

    def __str__(self) -> str:
        """Return the lines worded for a script: arguments in place of command-line options."""
        return "\n".join(in_a_line(str(line), True) for line in self.args)

    @property
    def typed(self) -> str:
        """All ``lines`` as one text, for pages and files that the program writes."""
        return "\n".join(self.lines)

    @property
    def message(self) -> str:
        """All lines as one text for a new error, with both wordings: command line and script."""
        return "\n".join(map(str, self.args))

    def within(self, source: object) -> Self:
        """Return the same error with ``source`` in front of each line."""
        return type(self)(*(f"{source}: {line}" for line in self.args))


class RunError(UserError):
    """Error outside the program, such as a full disk; the exit code is 1."""

    exit_code = 1


@contextmanager
def writing(place: Path) -> Iterator[None]:
    """Turn an OSError into a RunError that names the file or folder to be written."""
    try:
        yield
    except OSError as error:
        raise RunError(f"{place}: cannot be written: {error.strerror or error}") from None


Checked = TypeVar("Checked", bound=BaseModel)


def checked(
    model: type[Checked],
    data: Plain,
    source: str | Path,
    folder: Path,
    keys: Keys = NO_KEYS,
    **context: Any,
) -> Checked:
    """Return ``data`` of the file ``source`` as a record; relative paths in it start at ``folder``.

    ``keys`` are all keys that such a file may have. Validators receive ``context``.

    Raises:
        UserError: the model does not allow the data; one line for each mistake.
    """

    def check(data: Plain) -> Checked:
        return model.model_validate(data, context={"folder": folder, **context})

    try:
        return check(data)
    except ValidationError as error:
        raise UserError(*format_errors(error, data, check, keys)).within(source) from None
    except ArithmeticError:  # from what a validator computes
        fault = "holds a number too large or too small to compute with"
        raise UserError(f"{source}: {fault}") from None
