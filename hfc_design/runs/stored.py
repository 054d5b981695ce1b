"""The checkpoint of a run: what decides its result, and the search as far as it has come."""

from functools import cache
from importlib import metadata
from pathlib import Path

from hfc_design import __version__
from hfc_design.controllers.genome import Population
from hfc_design.core import checkpoint
from hfc_design.core.carried import AnyFile
from hfc_design.core.faults import short
from hfc_design.core.plugins import origins
from hfc_design.core.records import RunError
from hfc_design.files.named_scenario import renamed
from hfc_design.files.scenario import Scenario
from hfc_design.runs.individuals import genome_of, parts_of
from hfc_design.search.loop import STRATEGIES, Search, fault

#: Packages whose versions decide the last bits of a result.
PACKAGES = "jax", "jaxlib", "numpy", "scipy"
version = cache(metadata.version)  # a batch has many short cells
#: Bytes that a search may have beside its individuals, and beside the numbers of each.
SPARE, SPARE_EACH = 2**24, 64


def made_by(scenario: Scenario, folder: Path) -> dict[str, str]:
    """What decides the result of the run in a folder -> which it is: files, versions, own parts."""
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


def belongs(path: Path, made_by: dict[str, str], needed: dict[str, str], hint: str = "") -> None:
    """Refuse a file that was made by something else than is ``needed``; RunError: it was."""
    for key, now in needed.items():
        if (was := made_by.get(key)) is None:
            raise RunError(f"{path}: is of a version that did not say what made it{hint}")
        if was != now:
            which = f"{short(was, 20)}, here {short(now, 20)}"
            raise RunError(f"{path}: belongs to a run with another {key} ({which}){hint}")


def load(path: Path, scenario: Scenario, needed: dict[str, str], hint: str = "") -> Search | None:
    """The search in a file; None where there is no such file.

    Raises:
        RunError: it is damaged, or made by something else than is ``needed``; ``hint`` says what
            to do then.
    """
    if not path.exists():
        return None
    settings, genome = scenario.search, genome_of(scenario)
    empty, state = genome.empty(), STRATEGIES.get(settings.preset).state
    each = sum(array.nbytes for _, array in checkpoint.flat(empty)) // genome.structures
    # As much as of a search that remembers every individual that it has ever tried.
    tried = genome.structures + settings.population * (settings.generations + 1)
    fields = {"state": state, "population": empty, Population: empty}
    with checkpoint.doubted(path):
        made_by, arrays = checkpoint.read(path, SPARE + tried * (each + SPARE_EACH))
        belongs(path, made_by, needed, hint)
        search: Search = checkpoint.record_of(Search, fields, arrays)
        if wrong := fault(search, empty, settings):
            raise ValueError(wrong)
    return search
