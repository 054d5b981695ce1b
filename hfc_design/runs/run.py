"""A design run: scenario -> search -> run folder, with a checkpoint that survives anything."""

import shutil
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from hfc_design.controllers.genome import Population
from hfc_design.core import checkpoint
from hfc_design.core.plugins import resuming
from hfc_design.core.records import RunError, UserError
from hfc_design.files.design import Design, design_json, read_design
from hfc_design.files.pairing import load_design
from hfc_design.files.scenario import Scenario, load_scenario, renamed, scenario_toml
from hfc_design.runs.problem import Problem, champion, check_memory, genome_of, with_score
from hfc_design.search.loop import STRATEGIES, Search, generations, searcher
from hfc_design.simulation.evaluation import Evaluation, evaluate

CONFIG, CHECKPOINT, HISTORY, DESIGN = "config.toml", "checkpoint.npz", "history.csv", "design.json"
#: In the folder of a run that searches nothing: the design that it scores.
GIVEN = "given.json"
#: Seconds between checkpoints of a search that is faster than that.
CHECKPOINT_EVERY = 2.0


class Result(NamedTuple):
    """What a run found."""

    design: Design
    evaluation: Evaluation
    search: Search | None  # None where the design was given


def new_run(scenario: Scenario, folder: Path, given: Design | None = None) -> Scenario:
    """Create the run folder of ``scenario``; returns the scenario as the folder holds it.

    With a design that is ``given`` the run scores it and searches nothing.

    Raises:
        UserError: the folder already holds a run, or the run needs more memory than there is.
        RunError: the folder cannot be written.
    """
    if any((folder / name).exists() for name in (CONFIG, CHECKPOINT, DESIGN)):
        raise UserError(f"--out {folder}: already holds a run; add --resume or name another folder")
    check_memory(scenario, given)

    def copied(key: str, file: Path) -> Path:
        return Path(shutil.copyfile(file, folder / (key + file.suffix)).name)

    try:
        folder.mkdir(parents=True, exist_ok=True)
        own = renamed(scenario, copied)  # it stands alone
    except OSError as error:
        raise RunError(f"{folder}: cannot be written: {error.strerror or error}") from None
    if given is not None:
        _write_design(folder / GIVEN, given)
    checkpoint.write_whole(folder / CONFIG, scenario_toml(own).encode())
    return opened_run(folder)


def opened_run(folder: Path) -> Scenario:
    """The scenario of an existing run folder.

    Raises:
        UserError: there is no run in the folder.
    """
    if not (folder / CONFIG).is_file():
        raise UserError(f"--out {folder}: holds no run to resume (no file {CONFIG})")
    return load_scenario(str(folder / CONFIG))


def run(
    scenario: Scenario, folder: Path, on_generation: Callable[[Search], None] = lambda search: None
) -> Result:
    """Search from the start, or from the folder's checkpoint, and fill the folder.

    Stopped at any moment and called again, it ends with the same files as without the stop.

    Raises:
        RunError: everything diverged; the checkpoint is damaged or foreign; or the folder cannot be
            written.
    """
    if (folder / GIVEN).exists():
        given = load_design(str(folder / GIVEN))
        evaluation = evaluate(given, scenario)
        design = with_score(given, evaluation, scenario)
        _write_design(folder / DESIGN, design)
        return Result(design, evaluation, None)
    check_memory(scenario)
    problem, settings, seed = Problem(scenario), scenario.search, scenario.run.seed
    config = (folder / CONFIG).read_text(encoding="utf-8")
    search = _stored(folder, scenario, config)
    saved = time.monotonic()
    parts = (searcher(settings, problem.task), problem.genome, settings.generations, seed)
    steps = generations(*parts, problem.rank, search)
    try:
        for search in steps:
            on_generation(search)
            if time.monotonic() - saved > CHECKPOINT_EVERY:
                _save(folder, search, config)
                saved = time.monotonic()
    finally:
        if search is not None:
            _save(folder, search, config)
    assert search is not None  # there is at least one generation
    design, evaluation = champion(search, scenario)
    _write_design(folder / DESIGN, design)
    return Result(design, evaluation, search)


def _write_design(path: Path, design: Design) -> None:
    checkpoint.write_whole(path, (design_json(design) + "\n").encode())


def finished_run(folder: Path) -> tuple[Scenario, Result]:
    """The scenario and the result of a run that has ended, from its folder.

    Raises:
        UserError: there is no finished run in the folder, or its config or design is damaged.
        RunError: its checkpoint is damaged, foreign or gone.
    """
    for name in (CONFIG, DESIGN):
        if not (folder / name).exists():
            told = f"; {resuming(folder)}" if name == DESIGN else ""
            raise UserError(f"{folder}: holds no finished run (no {name}){told}")
    scenario = opened_run(folder)
    config = (folder / CONFIG).read_text(encoding="utf-8")
    search = _stored(folder, scenario, config)
    if search is None and not (folder / GIVEN).exists():
        raise RunError(f"{folder / CHECKPOINT}: is gone; what the search did is not known")
    design = read_design(folder / DESIGN)
    return scenario, Result(design, evaluate(design, scenario), search)


def _stored(folder: Path, scenario: Scenario, config: str) -> Search | None:
    if not (folder / CHECKPOINT).exists():
        return None
    example = genome_of(scenario).empty()
    state = STRATEGIES.get(scenario.search.preset).state
    kinds = {"state": state, "population": example, Population: example}
    search: Search = checkpoint.load(folder / CHECKPOINT, Search, kinds, config)
    return search


def _save(folder: Path, search: Search, config: str) -> None:
    checkpoint.save(folder / CHECKPOINT, search, config)
    lines = ["generation,best,median,diverged,structures"]
    columns = (column.tolist() for column in search.history)
    rows = enumerate(zip(*columns, strict=True))
    lines += [",".join(map(repr, (k, *row))) for k, row in rows]
    checkpoint.write_whole(folder / HISTORY, ("\n".join(lines) + "\n").encode())
