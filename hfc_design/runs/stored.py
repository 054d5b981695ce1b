"""What a run reads back from its folder: checkpoints of search and polish, files of numbers."""

import time
from collections.abc import Callable, Iterable
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

from pydantic import ConfigDict, Field

from hfc_design import __version__
from hfc_design.controllers.genome import Population
from hfc_design.core import archive, checkpoint, interrupt
from hfc_design.core.embedded_files import AnyFile
from hfc_design.core.numbers import Json
from hfc_design.core.plugins import origins
from hfc_design.core.records import Finite, Record, RunError, UserError, checked, in_a_line
from hfc_design.core.texts import read_json
from hfc_design.core.validation_errors import short
from hfc_design.files.named_scenario import renamed
from hfc_design.files.scenario import Scenario
from hfc_design.runs.individuals import genome_of, parts_of
from hfc_design.search.loop import STRATEGIES, Search, fault

#: Packages whose versions affect the last bits of a result.
PACKAGES = "jax", "jaxlib", "numpy", "scipy"
version = cache(metadata.version)  # a batch has many short cells
#: Bytes allowed in a checkpoint beyond its individuals, and for each of these beyond its numbers.
SPARE, SPARE_EACH = 2**24, 64
#: Shortest time between two checkpoints [s].
CHECKPOINT_EVERY = 2.0
Step = TypeVar("Step")
Named = Annotated[dict[str, Json], Field(min_length=1)]  # motion -> its numbers


class Numbers(Record):
    """Keys of a file that a page needs; other keys are allowed. Numbers must be finite."""

    model_config = ConfigDict(extra="ignore", frozen=True)


class AttainableFile(Numbers):
    """Keys of ``attainable.json``."""

    motions: Named
    left_out: str = ""


class _Margin(Numbers):
    value: Finite | None  # None: without limit
    at: str


class _Margins(Numbers):
    worst: dict[str, _Margin] = {}


class UsableFile(Numbers):
    """Keys of ``usable.json``."""

    usable: bool
    verdict: Literal["yes", "on this model only", "no"] | None = None  # None: an older file
    margins: _Margins | None = None
    stress: list[Json] = []
    why_not: Json | None = None
    answer: Annotated[str, Field(min_length=1)]
    missed: dict[str, Json] = {}
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
    motions: Named


def made_by(scenario: Scenario, folder: Path) -> dict[str, str]:
    """Return what determines the result of a run: digests of files, versions, own plug-ins."""
    files: list[AnyFile] = [folder / checkpoint.CONFIG]

    def noted(key: str, file: AnyFile) -> AnyFile:
        files.append(file)
        return file

    renamed(scenario, noted)
    return {
        **{file.name: checkpoint.digest(file.read_bytes()) for file in files},
        "hfc-design": __version__,
        **{name: version(name) for name in PACKAGES},
        **origins(parts_of(scenario, scenario.controller.model_dump())),
    }


def read(
    path: Path,
    largest: int,
    needed: dict[str, str],
    record: Callable[[archive.Arrays], Step],
    hint: str = "",
) -> Step | None:
    """Return ``record`` of the arrays in a file of ``largest`` bytes at most; None: no such file.

    Raises:
        RunError: the file is damaged, or was not made by what ``needed`` names; ``hint`` is advice
            for the second case.
    """
    if not path.exists():
        return None
    with checkpoint.corrupt_as_error(path):
        made_by, arrays = checkpoint.read(path, largest)
        for key, now in needed.items():
            if (was := made_by.get(key)) is None:
                old = "is of an old version that does not record its origin"
                raise RunError(f"{path}: {old}{hint}")
            if was != now:
                which = f"{short(was, 20)}, here {short(now, 20)}"
                raise RunError(f"{path}: belongs to a run with another {key} ({which}){hint}")
        return record(arrays)


def load(path: Path, scenario: Scenario, needed: dict[str, str], hint: str = "") -> Search | None:
    """Return the search stored in a file, as ``read`` does."""
    settings, genome = scenario.search, genome_of(scenario)
    empty, state = genome.empty(), STRATEGIES.get(settings.preset).state
    each = sum(array.nbytes for _, array in checkpoint.flat(empty)) // genome.structures
    # Enough for a search that stores every individual that it has ever tried.
    tried = genome.structures + settings.population * (settings.generations + 1)

    def search(arrays: archive.Arrays) -> Search:
        fields = {"state": state, "population": empty, Population: empty}
        loaded: Search = checkpoint.record_of(Search, fields, arrays)
        if wrong := fault(loaded, empty, settings):
            raise ValueError(wrong)
        return loaded

    return read(path, SPARE + tried * (each + SPARE_EACH), needed, search, hint)


def checkpointed(
    steps: Iterable[Step],
    before: Step | None,
    save: Callable[[Any], None],
    on_step: Callable[[Step], None],
) -> Step:
    """Take all ``steps`` after the step ``before``; ``save`` from time to time and at the end.

    Return the last step, or ``before`` if no step was left.
    """
    done, saved = before, time.monotonic()
    try:
        for step in steps:
            done = step
            interrupt.heard()
            on_step(step)
            if time.monotonic() - saved > CHECKPOINT_EVERY:
                save(step)
                saved = time.monotonic()
    finally:
        if done is not None:
            save(done)
    assert done is not None  # there is at least one step
    return done


def read_numbers(path: Path, model: type[Numbers], show: Callable[[Json], object]) -> Json | None:
    """Return the numbers in a file of a run; None if there is no file.

    ``show`` makes of the numbers what pages contain of them.

    Raises:
        RunError: the file is damaged: a key is missing or wrong, or the numbers cannot be shown.
    """
    if not path.exists():
        return None
    try:
        numbers: Json = read_json(path)
        checked(model, numbers, path, path.parent)
        show(numbers)
    except UserError as error:
        fault = str(error.args[0]).removeprefix(f"{path}: ")[:100]
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        fault = in_a_line(f"cannot be shown ({type(error).__name__}: {error})")[:100]
    else:
        return numbers
    raise RunError(f"{path}: {fault}; remove the damaged file")
