"""The batch file, and the cells that it asks for."""

import hashlib
import tomllib
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import Field

from hfc_design.records import Record, UserError, checked
from hfc_design.scenarios import Scenario, load_scenario, renamed, scenario_toml

#: More cells than this are a mistake of a factor of ten somewhere.
MAX_CELLS = 100_000


class BatchFile(Record):
    """``hfc batch``: keys are the scenario's dotted keys, and ``scenario`` for its name."""

    description: str = ""
    set: dict[str, Any] = {}  # the same in every cell
    grid: dict[str, Any] = {}  # lists: every combination is a cell
    cells: tuple[dict[str, Any], ...] = Field((), max_length=MAX_CELLS)  # each with the whole grid


class Cell(NamedTuple):
    """One run of a batch."""

    name: str  # of its folder: the hash of its whole configuration
    settings: dict[str, Any]  # dotted key -> value, as far as the batch file says
    scenario: Scenario


def read_batch(path: Path) -> list[Cell]:
    """The cells of a batch file, in its order; cells that are the same run are one.

    Raises:
        UserError: the file is none, or a scenario that it makes is not allowed.
    """
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise UserError(f"{path}: cannot be read: {error}") from None
    except tomllib.TOMLDecodeError as error:
        raise UserError(f"{path}: is not valid TOML: {error}") from None
    file = checked(BatchFile, data, path, path.parent)
    found: dict[str, Cell] = {}
    for settings in _combinations(file, path):
        cell = _cell(settings, path)
        found.setdefault(cell.name, cell)
    return list(found.values())


def _combinations(file: BatchFile, path: Path) -> Iterator[dict[str, Any]]:
    """The settings of each cell."""
    common, grid = flat(file.set), flat(file.grid)
    for key, values in grid.items():
        if not isinstance(values, list) or not values:
            raise UserError(f"{path}: grid.{key} = {values!r}: has to be a list of values")
    count = max(len(file.cells), 1)
    for values in grid.values():
        count *= len(values)
    if count > MAX_CELLS:
        raise UserError(f"{path}: asks for {count} cells; allowed are {MAX_CELLS}")
    for own in file.cells or ({},):
        for values in product(*grid.values()):
            yield common | dict(zip(grid, values, strict=True)) | flat(own)


def flat(table: dict[str, Any], prefix: str = "") -> dict[str, Any]:
    """Nested tables as dotted keys; TOML reads ``run.seed = 1`` as a table in a table."""
    found: dict[str, Any] = {}
    for key, value in table.items():
        nested = isinstance(value, dict)
        found |= flat(value, f"{prefix}{key}.") if nested else {prefix + key: value}
    return found


def _cell(settings: dict[str, Any], path: Path) -> Cell:
    name = settings.get("scenario", "c-axis-ramp")
    beside = path.parent / str(name)
    changes = {key: value for key, value in settings.items() if key != "scenario"}
    try:
        scenario = load_scenario(str(beside if beside.is_file() else name), changes)
    except UserError as error:
        told = ", ".join(f"{key} = {value!r}" for key, value in settings.items())
        raise UserError(f"{path}: cell with {told}: {error}") from None
    return Cell(_name(scenario), settings, scenario)


def _name(scenario: Scenario) -> str:
    """The hash of the configuration, with the contents of the files that it names."""

    def by_content(key: str, file: Path) -> Path:
        return Path(hashlib.sha256(file.read_bytes()).hexdigest())

    text = scenario_toml(renamed(scenario, by_content))
    return hashlib.sha256(text.encode()).hexdigest()[:16]
