"""The batch file: what a user writes."""

import tomllib
from pathlib import Path
from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from hfc_design.core.dotted import flat
from hfc_design.core.records import Finite, Name, Record, UserError, checked

#: More cells than this are a mistake of a factor of ten somewhere.
MAX_CELLS = 100_000
#: What a cell says beside its scenario's keys: which scenario; a design to be scored, instead of
#: a search; a word that ``published`` and a reader know the cell by.
SCENARIO, DESIGN, LABEL = OWN_KEYS = "scenario", "design", "label"
#: Letters in a label.
LONGEST = 120
#: What dotted keys of a design begin with.
CHANGE = "change."


def _with_label(settings: Any) -> Any:
    return {LABEL: settings} if isinstance(settings, str) else settings


Settings = Annotated[dict[str, Any], BeforeValidator(_with_label)]


class Published(Record):
    """A published figure, and which metric of which runs stands beside it.

    ``of`` and ``over`` are settings of cells, or a label; with ``over`` it is the ratio of both
    runs' metrics.
    """

    figure: str = ""  # of the paper
    quantity: str  # with its unit
    value: Finite | None = None  # None: the paper has words only
    metric: str  # or "fitness", or "merit"
    of: Settings
    over: Settings = {}
    over_metric: str = ""  # left out: the same metric
    remark: str = ""


class BatchFile(Record):
    """``hfc batch``: keys are dotted ones of a scenario, and those named in ``OWN_KEYS``."""

    name: Name | None = None  # of the folder in runs/; None: that of the file
    description: str = ""
    set: dict[str, Any] = {}  # the same in every cell
    grid: dict[str, Any] = {}  # lists: every combination is a cell
    cells: tuple[dict[str, Any], ...] = Field((), max_length=MAX_CELLS)  # each with the whole grid
    published: tuple[Published, ...] = ()


def read_file(path: Path) -> BatchFile:
    """The batch file at a path.

    Raises:
        UserError: the file is none.
    """
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise UserError(f"{path}: cannot be read: {error}") from None
    except tomllib.TOMLDecodeError as error:
        raise UserError(f"{path}: is not valid TOML: {error}") from None
    file = checked(BatchFile, data, path, path.parent)
    if not (file.set or file.grid or file.cells):
        raise UserError(f"{path}: asks for nothing; it needs [set], [grid] or [[cells]]")
    return file


def matches(wanted: dict[str, Any], settings: dict[str, Any]) -> bool:
    """Whether a run has all of the wanted settings."""
    return all(key in settings and settings[key] == value for key, value in flat(wanted).items())
