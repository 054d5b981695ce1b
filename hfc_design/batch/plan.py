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
#: Prefix of the keys of a cell that change values of the given design.
CHANGE = "change."
#: Settings that select cells; a string stands for their label.
Settings = Annotated[Json, BeforeValidator(lambda x: {LABEL: x} if isinstance(x, str) else x)]


class Published(Record):
    """A number that a paper states, and the metric of the runs that is compared with it.

    ``of`` and ``over`` select runs by settings or by a label. With ``over``, the compared number is
    a ratio: the metric of the runs ``of``, divided by that of the runs ``over``.
    """

    figure: str = ""  # number of the figure in the paper
    quantity: str  # with its unit
    value: Finite | None = None  # None: the paper states the result in words only
    metric: str  # a metric, "fitness" or "merit"
    of: Settings
    over: Settings = {}
    over_metric: str = ""  # "": the same as ``metric``
    remark: str = ""

    @property
    def sides(self) -> list[tuple[Json, str]]:
        """Settings and metric of the compared runs; for a ratio, then those of the denominator."""
        pairs = [(self.of, self.metric)]
        if self.over or self.over_metric:
            pairs.append((self.over or self.of, self.over_metric or self.metric))
        return pairs


class BatchNotes(Record):
    """Entries of a batch file that do not describe cells."""

    description: str = ""
    published: tuple[Published, ...] = ()


class BatchFile(BatchNotes):
    """Batch file of ``hfc batch``; its cells have ``OWN_KEYS`` and dotted keys of a scenario."""

    name: Name | None = None  # of the folder in runs/; None: the name of the file
    set: Json = {}  # the same in every cell
    grid: Json = {}  # lists: every combination is a cell
    cells: tuple[Json, ...] = Field((), max_length=MAX_CELLS)  # each combined with the whole grid


class Cell(NamedTuple):
    """One run of a batch."""

    name: str  # of its folder: the hash of its whole configuration
    settings: Json  # dotted key -> value, only keys that the batch file sets
    scenario: Scenario
    design: Design | None = None  # scored without a search; None: the run searches a design


class Plan(NamedTuple):
    """Cells and notes of a batch file."""

    name: str  # of its folder
    cells: list[Cell]
    notes: BatchNotes

    def folder(self, out: Path | None) -> Path:
        """Folder of the cells: ``out``, or the default."""
        return out or Path("runs") / self.name


def read_batch(path: Path, changes: Changes = ()) -> Plan:
    """Return the cells and notes of a batch file; identical cells are merged.

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
    """Raise a UserError if no cell has the wanted settings, or none of these has the metric."""
    some = [cell for cell in cells if matches(wanted, cell.settings)]
    if not some:
        raise UserError(f"no cell has {_listed(flat(wanted))}")
    metrics = (key for cell in some for key in meanings(cell.scenario))
    known = list(dict.fromkeys(["fitness", "merit", *metrics]))
    if metric not in known:
        raise UserError(f"{metric!r}: unknown metric of these cells; {one_of(metric, known)}")


def _combinations(file: BatchFile, path: Path) -> Iterator[Json]:
    """Yield the settings of each cell: ``set``, overridden by the grid, then by the cell's own."""
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
    """Return the scenario of a cell, and the design that it scores; None: it searches."""
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
    return scenario.model_copy(update={"run": RunSettings()}), design  # a score has no seed


def _name(scenario: Scenario, design: Design | None) -> str:
    """Return a hash of the configuration, including the contents of the files that it names."""

    def by_content(key: str, file: AnyFile) -> Path:
        return Path(hashlib.sha256(file.read_bytes()).hexdigest())

    text = scenario_toml(renamed(scenario, by_content))
    if design is not None:
        text += design_json(design)
    return hashlib.sha256(text.encode()).hexdigest()[:16]
