"""Files of numbers that a run stores with its design, checked when they are read."""

from pathlib import Path
from typing import Annotated, Literal, TypeVar

from pydantic import ConfigDict, Field

from hfc_design.core.numbers import Json
from hfc_design.core.records import Finite, NotNegative, Record, RunError, UserError, checked
from hfc_design.core.texts import as_user_error, content, decoded, json_of

Item = TypeVar("Item")
#: Name of a motion -> its values; at least one motion.
Named = Annotated[dict[str, Item], Field(min_length=1)]


class Numbers(Record):
    """Content of a file that a page needs; other keys are allowed. Numbers must be finite."""

    model_config = ConfigDict(extra="ignore", frozen=True)


class _Reached(Numbers):
    bound: NotNegative
    reached: NotNegative
    sum_error: NotNegative | None = None


class AttainableFile(Numbers):
    """Content of ``attainable.json``."""

    motions: Named[_Reached]
    left_out: str = ""


class _Measure(Numbers):
    median: Finite | None
    q95: Finite | None = None  # a share has none
    largest: Finite | None


class _InMotion(Numbers):
    share: Finite
    reasons: dict[str, int]
    asked_of: Literal["all", "nominal"] = "all"
    measures: Annotated[dict[str, _Measure], Field(min_length=4, max_length=4)]


class _Missed(Numbers):
    times: Finite
    motion: str


class _Stress(Numbers):
    name: str
    holds: bool
    share: Finite
    merit: Finite | None
    part: Finite
    breaks: str
    why: str


class _Change(Numbers):
    key: str
    now: str
    needed: str | None
    lost: int | None
    without: Finite


class _WhyNot(Numbers):
    changes: list[_Change]
    lines: list[str]


class UsableFile(Numbers):
    """Content of ``usable.json``."""

    usable: bool
    verdict: Literal["yes", "on this model only", "no"] | None = None  # None: an older file
    stress: list[_Stress] = []
    why_not: _WhyNot | None = None
    answer: Annotated[str, Field(min_length=1)]
    missed: dict[str, _Missed] = {}
    spread: Finite
    machines: int
    share: Finite
    interval: tuple[Finite, Finite]
    gain: tuple[Finite, Finite] | None
    precision: Finite | None
    substeps: Finite | None
    repeats: dict[str, Finite | None] = {}
    chaotic: bool = False
    units: Annotated[dict[str, str], Field(min_length=3, max_length=3)]
    motions: Named[_InMotion]


def read_numbers(path: Path, model: type[Numbers]) -> Json | None:
    """Return the numbers in a file of a run; None if there is no file. RunError: it is damaged."""
    if not path.exists():
        return None
    try:
        with as_user_error(path):
            numbers: Json = json_of(decoded(content(path)))
        checked(model, numbers, path, path.parent)
    except UserError as error:
        fault = str(error.args[0]).removeprefix(f"{path}: ")[:100]
        raise RunError(f"{path}: {fault}; remove the damaged file") from None
    return numbers
