"""The batch file as a user writes it, and the cells that it describes."""

import hashlib
from collections.abc import Iterable, Iterator, Mapping
from itertools import product
from math import prod
from os.path import exists
from pathlib import Path
from typing import Annotated, NamedTuple

from pydantic import BeforeValidator, Field

from hfc_design.core.embedded_files import AnyFile
from hfc_design.core.numbers import Json
from hfc_design.core.overrides import Changes, flat, set_keys
from hfc_design.core.records import Finite, Name, Record, UserError, checked
from hfc_design.core.texts import read_toml
from hfc_design.core.wording import one_of
from hfc_design.files.design import Design, design_json
from hfc_design.files.labels import LABEL
from hfc_design.files.loop_setup import load_design, machine, own_scenario
from hfc_design.files.named_scenario import load_scenario, renamed, scenario_toml
from hfc_design.files.scenario import RunSettings, Scenario
from hfc_design.simulation.evaluating import meanings

#: Largest number of cells; more are most likely a mistake.
MAX_CELLS = 100_000
#: Keys of a cell beside those of its scenario: name of the scenario; a design to be scored instead
#: of a search; a label of the cell for ``published`` and for readers.
SCENARIO, DESIGN = "scenario", "design"
OWN_KEYS = SCENARIO, DESIGN, LABEL
#: Largest length of a label.
LONGEST = 120
#: Prefix of the dotted keys of a design.
CHANGE = "change."
#: Settings of cells; a string is their label.
Settings = Annotated[Json, BeforeValidator(lambda x: {LABEL: x} if isinstance(x, str) else x)]


class Published(Record):
    """A published figure, and the metric of the runs that it is compared with.

    ``of`` and ``over`` are settings of cells, or a label; with ``over``, the compared number is the
    ratio of the metrics of both runs.
    """

    figure: str = ""  # of the paper
    quantity: str  # with its unit
    value: Finite | None = None  # None: the paper has words only
    metric: str  # or "fitness", or "merit"
    of: Settings
    over: Settings = {}
    over_metric: str = ""  # left out: the same metric
    remark: str = ""

    @property
    def sides(self) -> list[tuple[Json, str]]:
        """Settings and metric of the runs, and those of the denominator of a ratio."""
        pairs = [(self.of, self.metric)]
        if self.over or self.over_metric:
            pairs.append((self.over or self.of, self.over_metric or self.metric))
        return pairs


class BatchNotes(Record):
    """Entries of a batch file beside its cells."""

    description: str = ""
    published: tuple[Published, ...] = ()


class BatchFile(BatchNotes):
    """Batch file of ``hfc batch``: keys are those in ``OWN_KEYS`` and a scenario's dotted keys."""

    name: Name | None = None  # of the folder in runs/; None: that of the file
    set: Json = {}  # the same in every cell
    grid: Json = {}  # lists: every combination is a cell
    cells: tuple[Json, ...] = Field((), max_length=MAX_CELLS)  # each with the whole grid


class Cell(NamedTuple):
    """One run of a batch."""

    name: str  # of its folder: the hash of its whole configuration
    settings: Json  # dotted key -> value, as far as the batch file says
    scenario: Scenario
    design: Design | None = None  # to be scored; None: the run searches one


class Plan(NamedTuple):
    """Cells and notes of a batch file."""

    name: str  # of its folder
    cells: list[Cell]
    notes: BatchNotes

    def folder(self, out: Path | None) -> Path:
        """Folder of the cells: ``out``, or the default."""
        return out or Path("runs") / self.name


def read_batch(path: Path, changes: Changes = ()) -> Plan:
    """Cells of a batch file, in its order; identical cells are merged.

    ``changes`` of dotted keys are applied to every cell.

    Raises:
        UserError: the file is not a valid batch file, or one of its runs is not valid.
    """
    file = checked(BatchFile, read_toml(path), path, path.parent)
    if not (file.set or file.grid or file.cells):
        raise UserError(f"{path}: must have [set], [grid] or [[cells]]")
    cells: dict[str, Cell] = {}
    common = flat(file.set)
    others = {**changes} if isinstance(changes, Mapping) else set_keys(changes, "set")
    for combination in _combinations(file, path):
        settings = combination | others
        try:
            scenario, design = _run_of(settings, path.parent)
        except UserError as error:
            apart = {key: x for key, x in settings.items() if common.get(key) != x} or settings
            first, *more = error.args
            lines = [f"cell with {_listed(apart)}: {first}", *(f"same cell: {x}" for x in more)]
            raise type(error)(*(f"{path}: {line}" for line in lines)) from None
        name = _name(scenario, design)
        cells.setdefault(name, Cell(name, settings, scenario, design))
    for k, item in enumerate(file.published):
        try:
            for wanted, metric in item.sides:
                if wanted:
                    _check_figure(wanted, metric, cells.values())
        except UserError as error:
            raise error.within(f"{path}: published.{k}") from None
    return Plan(file.name or path.stem, list(cells.values()), file)


def matches(wanted: Json, settings: Json) -> bool:
    """True if a run has all of the wanted settings."""
    return all(key in settings and settings[key] == value for key, value in flat(wanted).items())


def _check_figure(wanted: Json, metric: str, cells: Iterable[Cell]) -> None:
    """Raise an error for a metric that no cell with the wanted settings has."""
    some = [cell for cell in cells if matches(wanted, cell.settings)]
    if not some:
        raise UserError(f"no cell has {_listed(flat(wanted))}")
    metrics = (key for cell in some for key in meanings(cell.scenario))
    known = list(dict.fromkeys(["fitness", "merit", *metrics]))
    if metric not in known:
        raise UserError(f"{metric!r}: unknown metric of these cells; {one_of(metric, known)}")


def _combinations(file: BatchFile, path: Path) -> Iterator[Json]:
    """Settings of each cell."""
    common, grid = flat(file.set), flat(file.grid)
    for key, values in grid.items():
        if not isinstance(values, list) or not values:
            raise UserError(f"{path}: grid.{key} = {values!r}: must be a list of values")
    count = max(len(file.cells), 1) * prod(map(len, grid.values()))
    if count > MAX_CELLS:
        raise UserError(f"{path}: must have at most {MAX_CELLS} cells (got {count})")
    for cell in file.cells or ({},):
        for values in product(*grid.values()):
            yield common | dict(zip(grid, values, strict=True)) | flat(cell)


def _listed(settings: Json) -> str:
    words = ", ".join(f"{key} = {value!r}" for key, value in settings.items())
    return words if len(words) <= LONGEST else f"{words[: LONGEST - 40]} ..."


def _run_of(settings: Json, folder: Path) -> tuple[Scenario, Design | None]:
    """Scenario of a cell, and the design that it scores if it has no search."""
    label = settings.get(LABEL, "a")
    if not isinstance(label, str) or not label.isprintable() or not 1 <= len(label) <= LONGEST:
        raise UserError(f"label: must be a string of 1 to {LONGEST} printable characters")
    keys = {key: value for key, value in settings.items() if key not in OWN_KEYS}
    inside = {key.removeprefix(CHANGE): x for key, x in keys.items() if key.startswith(CHANGE)}
    keys = {key: value for key, value in keys.items() if not key.startswith(CHANGE)}

    def place(name: object) -> str:
        """Resolve a name in a batch file: beside the file, in the working folder, or built in."""
        return str(folder / str(name) if exists(folder / str(name)) else name)

    name = settings.get(SCENARIO)
    if DESIGN not in settings:
        if inside:
            raise UserError(f"{CHANGE}{next(iter(inside))}: needs a design to change")
        return load_scenario(place(name or "c-axis-ramp"), keys), None
    source = place(settings[DESIGN])
    design = load_design(source, inside)
    if name is None:
        scenario = own_scenario(design, source, keys)
    else:
        scenario = load_scenario(place(name), keys)
    machine(design, scenario)  # refuses a design that does not fit
    return scenario.model_copy(update={"run": RunSettings()}), design  # nothing is random


def _name(scenario: Scenario, design: Design | None) -> str:
    """Hash of the configuration, with the contents of the files that it names."""

    def by_content(key: str, file: AnyFile) -> Path:
        return Path(hashlib.sha256(file.read_bytes()).hexdigest())

    text = scenario_toml(renamed(scenario, by_content))
    if design is not None:
        text += design_json(design)
    return hashlib.sha256(text.encode()).hexdigest()[:16]
