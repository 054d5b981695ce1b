"""Numbers that a run's folder has beside its design, as they are read back: checked."""

from pathlib import Path
from typing import Annotated, Literal

from pydantic import ConfigDict, Field

from hfc_design.core.numbers import Json
from hfc_design.core.records import (
    Finite,
    NotNegative,
    Record,
    RunError,
    UserError,
    checked,
)
from hfc_design.core.texts import about, content, decoded, json_of


class Beside(Record):
    """What a page needs of a file; it may have more."""

    model_config = ConfigDict(extra="ignore", frozen=True)


class Reached(Beside):
    """``attainable.json``, of a motion."""

    bound: NotNegative
    reached: NotNegative
    sum_error: NotNegative | None = None


class AttainableFile(Beside):
    """``attainable.json``."""

    motions: Annotated[dict[str, Reached], Field(min_length=1)]
    left_out: str = ""


class Measure(Beside):
    """``usable.json``, of a measure; no number where it is not finite."""

    median: Finite | None
    q95: Finite | None = None  # a share has none
    largest: Finite | None


class InMotion(Beside):
    """``usable.json``, of a motion."""

    share: Finite
    reasons: dict[str, int]
    asked_of: Literal["all", "nominal"] = "all"
    measures: Annotated[dict[str, Measure], Field(min_length=4, max_length=4)]


class Missed(Beside):
    """``usable.json``, of a tolerance."""

    times: Finite
    motion: str


class Ends(Beside):
    """``usable.json``, of a merit that is chaotic."""

    lowest: Finite | None
    highest: Finite | None


class UsableFile(Beside):
    """``usable.json``."""

    usable: bool
    answer: Annotated[str, Field(min_length=1)]
    missed: dict[str, Missed] = {}
    spread: Finite
    machines: int
    share: Finite
    interval: tuple[Finite, Finite]
    gain: tuple[Finite, Finite] | None
    precision: Finite | None
    substeps: Finite | None
    repeats: Ends = Ends(lowest=None, highest=None)
    chaotic: bool = False
    units: Annotated[dict[str, str], Field(min_length=3, max_length=3)]
    motions: Annotated[dict[str, InMotion], Field(min_length=1)]


def beside(path: Path, model: type[Beside]) -> Json | None:
    """What a file beside a run's design says; None if there is none.

    Raises:
        RunError: it is damaged.
    """
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
