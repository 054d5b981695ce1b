"""Numbers that a run's folder has beside its design, as they are read back: checked."""

from pathlib import Path
from typing import Annotated, Literal, TypeVar

from pydantic import ConfigDict, Field

from hfc_design.core.numbers import Json
from hfc_design.core.records import Finite, NotNegative, Record, RunError, UserError, checked
from hfc_design.core.texts import about, content, decoded, json_of

Item = TypeVar("Item")
#: By the names of motions; of at least one.
Named = Annotated[dict[str, Item], Field(min_length=1)]


class Beside(Record):
    """What a page needs of a file; it may have more. No number stands where one is not finite."""

    model_config = ConfigDict(extra="ignore", frozen=True)


class _Reached(Beside):
    bound: NotNegative
    reached: NotNegative
    sum_error: NotNegative | None = None


class AttainableFile(Beside):
    """``attainable.json``."""

    motions: Named[_Reached]
    left_out: str = ""


class _Measure(Beside):
    median: Finite | None
    q95: Finite | None = None  # a share has none
    largest: Finite | None


class _InMotion(Beside):
    share: Finite
    reasons: dict[str, int]
    asked_of: Literal["all", "nominal"] = "all"
    measures: Annotated[dict[str, _Measure], Field(min_length=4, max_length=4)]


class _Missed(Beside):
    times: Finite
    motion: str


class _Ends(Beside):
    lowest: Finite | None = None
    highest: Finite | None = None


class _Stress(Beside):
    name: str
    holds: bool
    share: Finite
    merit: Finite | None
    part: Finite
    breaks: str
    why: str


class UsableFile(Beside):
    """``usable.json``."""

    usable: bool
    verdict: Literal["yes", "on this model only", "no"] | None = None  # of older files
    stress: list[_Stress] = []
    answer: Annotated[str, Field(min_length=1)]
    missed: dict[str, _Missed] = {}
    spread: Finite
    machines: int
    share: Finite
    interval: tuple[Finite, Finite]
    gain: tuple[Finite, Finite] | None
    precision: Finite | None
    substeps: Finite | None
    repeats: _Ends = _Ends()
    chaotic: bool = False
    units: Annotated[dict[str, str], Field(min_length=3, max_length=3)]
    motions: Named[_InMotion]


def beside(path: Path, model: type[Beside]) -> Json | None:
    """What a file beside a run's design says; None if there is none. RunError: it is damaged."""
    if not path.exists():
        return None
    try:
        with about(path):
            found: Json = json_of(decoded(content(path)))
        checked(model, found, path, path.parent)
    except UserError as error:
        told = str(error.args[0]).removeprefix(f"{path}: ")[:100]
        raise RunError(f"{path}: {told}; remove the damaged file") from None
    return found
