"""A design run: scenario -> search -> run folder, with a checkpoint that survives interruptions."""

import json
import shlex
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from hfc_design.core import checkpoint
from hfc_design.core.embedded_files import AnyFile
from hfc_design.core.numbers import Json
from hfc_design.core.plugins import resuming
from hfc_design.core.records import RunError, UserError, option, writing
from hfc_design.core.tables import line, table
from hfc_design.core.texts import read_json
from hfc_design.files.design import Design, design_json, naming, read_design
from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import config_toml, load_scenario, renamed
from hfc_design.files.scenario import Scenario
from hfc_design.runs import champion, stored
from hfc_design.runs.champion import LAP, LEAST_VIOLATED, Lap
from hfc_design.runs.front import FRONT, Front, front_of, read_front, write_front
from hfc_design.runs.individuals import noted, with_score
from hfc_design.runs.polishing import check_polish, polished
from hfc_design.runs.problem import Problem, check_memory
from hfc_design.search.loop import Search, generations, searcher
from hfc_design.search.polish import Polished
from hfc_design.simulation.acceptance import NO, Usable, missed_text
from hfc_design.simulation.evaluating import Evaluation, evaluate
from hfc_design.simulation.stability_criteria import reasons_text
from hfc_design.simulation.usable import usable
from hfc_design.simulation.usable_tables import motions_table, tables

CONFIG, CHECKPOINT = checkpoint.CONFIG, "checkpoint.npz"
USABLE = "usable.json"
#: Keys of the usability that the score of a design file contains.
KEPT = "verdict", "share", "interval", "spread", "machines", "seed", "missed", "stress"
HISTORY, DESIGN = "history.csv", "design.json"
#: File in the folder of a run without a search: the design that it scores.
GIVEN = "given.json"
#: Message for contradictory constraints, or a spread that no design tolerates.
NO_DESIGN = "no design tried meets every constraint; this one violates them least"
HINT = f"; to continue nevertheless add {option('anyway', True)}"


class Result(NamedTuple):
    """Result of a run."""

    design: Design
    evaluation: Evaluation
    search: Search | None  # None: the design was given
    front: Front | None = None  # None: the search has no trade-off

    def __repr__(self) -> str:
        return line("Result", self._shown())

    def _repr_html_(self) -> str:
        return table("Result", self._shown() | self.evaluation.metrics)

    def _shown(self) -> dict[str, object]:
        numbers = {key: getattr(self.evaluation, key) for key in ("fitness", "merit", "diverged")}
        searched = {"generations": self.search.generation} if self.search else {}
        return {"design": self.design.name, **numbers, **searched}


def new_run(scenario: Scenario, folder: Path, given: Design | None = None) -> Scenario:
    """Create the run folder of ``scenario``; return the scenario as the folder contains it.

    With a ``given`` design the run scores it and has no search.

    Raises:
        UserError: the folder already contains a run.
        RunError: the folder cannot be written.
    """
    check_polish(scenario)
    if any((folder / name).exists() for name in (CONFIG, CHECKPOINT, DESIGN, FRONT)):
        resume = f"hfc design --resume --out {shlex.quote(folder.as_posix())}"
        advice = f"name another folder, or continue it: {resume}"
        raise UserError(f"{option('out', str(folder), 'folder')}: already has a run; {advice}")

    def copied(key: str, file: AnyFile) -> Path:
        checkpoint.write_whole(folder / (key + file.suffix), file.read_bytes())
        return Path(key + file.suffix)

    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
        checkpoint.synced(folder.parent)
        movable = renamed(scenario, copied)  # no file outside is needed
    if given is not None:
        _write_design(folder / GIVEN, given)
    checkpoint.write_whole(folder / CONFIG, config_toml(movable).encode())
    return opened_run(folder)


@contextmanager
def begun(folder: Path) -> Iterator[None]:
    """Context of a new run: if it is refused before its first checkpoint, its files are removed."""
    before = {*folder.iterdir()}
    try:
        yield
    except RunError:  # an interrupted one can be resumed
        raise
    except UserError:
        if not (folder / CHECKPOINT).exists():
            for file in {*folder.iterdir()} - before:
                file.unlink()
        raise


def opened_run(folder: Path) -> Scenario:
    """Return the scenario of an existing run folder; UserError: there is no run in it."""
    if not (folder / CONFIG).is_file():
        place = option("out", str(folder), "folder")
        raise UserError(f"{place}: has no run to resume (no file {CONFIG})")
    with naming(provenance(folder / DESIGN)):
        return load_scenario(str(folder / CONFIG))


def provenance(path: Path) -> Json:
    """Return the versions and files that made a run's design; empty if they cannot be read."""
    try:
        return dict(read_json(path)["provenance"])
    except (UserError, ValueError, TypeError, KeyError):  # ``read_design`` will explain it
        return {}


def run(
    scenario: Scenario,
    folder: Path,
    on_generation: Callable[[Search], None] = lambda search: None,
    anyway: bool = False,
    on_polish: Callable[[Polished], None] = lambda done: None,
    on_lap: Callable[[Lap], None] = lambda lap: None,
) -> Result:
    """Search from the start, or from the folder's checkpoint, and write the files of the folder.

    The search is repeated until the design is usable: up to ``champion.laps`` searches in all. A
    run that is stopped and called again ends with the same files as an uninterrupted one.

    Raises:
        UserError: it needs more memory than there is.
        RunError: everything diverged; the checkpoint is damaged, or was made by another version,
            file or own part and ``anyway`` is false; or the folder cannot be written.
    """
    checkpoint.tidy(folder)
    if (folder / GIVEN).exists():
        given = load_design(str(folder / GIVEN))
        evaluation = evaluate(given, scenario)
        design = with_score(given, evaluation, scenario)
        return _finished(scenario, folder, Result(design, evaluation, None))
    check_memory(scenario)
    made_by = stored.made_by(scenario, folder)
    needed = {} if anyway else made_by
    best: Lap | None = None
    for k in range(champion.laps(scenario)):
        path = folder / champion.lap_file(CHECKPOINT, k)
        search = _searched(champion.lap_of(scenario, k), path, needed, made_by, on_generation)
        front = front_of(search, scenario) if k == 0 else None
        lap = champion.tried_lap(scenario, k, search, front)
        best = lap if best is None or lap.rank > best.rank else best
        if lap.use is None or lap.use.yes:
            break
        if k + 1 < champion.laps(scenario):
            on_lap(lap)
    assert best is not None
    individual, design, evaluation = best.finalist
    if best.number:
        design = noted(design, {LAP: best.number})
        _save_history(folder, best.search)
    if scenario.run.polish:
        begun = (individual, design, evaluation)
        design, evaluation = polished(scenario, folder, begun, made_by, needed, on_polish)
    result = Result(design, evaluation, best.search, best.front)
    return _finished(scenario, folder, result, None if scenario.run.polish else best.answer)


def _finished(
    scenario: Scenario, folder: Path, result: Result, use: Usable | None = None
) -> Result:
    """Write the files of a result, the design last; return the result with its usability."""
    if scenario.robust:
        numbers = used(scenario, result, folder, use)
        result = result._replace(design=_with_use(result.design, numbers))
    if result.front is not None:
        write_front(result.front, folder)
    _write_design(folder / DESIGN, result.design)
    return result


def _searched(
    scenario: Scenario,
    path: Path,
    needed: dict[str, str],
    made_by: dict[str, str],
    on_generation: Callable[[Search], None],
) -> Search:
    """Return the finished search of a lap, begun anew or continued from its checkpoint ``path``."""
    before = stored.load(path, scenario, needed, HINT)
    problem, settings = Problem(scenario), scenario.search
    parts = (searcher(settings, problem.task), problem.genome, settings.generations)
    steps = generations(*parts, scenario.run.seed, problem.scored, before)

    def save(search: Search) -> None:
        checkpoint.save(path, search, made_by)
        _save_history(path.parent, search)

    return stored.checkpointed(steps, before, save, on_generation)


def front_needed(folder: Path, result: Result) -> Front:
    """Return the front of a finished run; UserError: the run has no front, or an empty one."""
    if result.front is None:
        search = "hfc design --pareto tracking,effort"
        raise UserError(f"{folder}: has no front; to search for one run {search}")
    if not len(result.front.merit):
        raise UserError(f"{folder}: its front is empty, as no design met every constraint")
    return result.front


def picked(
    scenario: Scenario, result: Result, point: int
) -> tuple[Design, Evaluation, Json | None]:
    """Return design, evaluation and usability (as JSON) of a point of the front, counted from 0.

    The usability is None if the scenario has no ``[robust]``.

    Raises:
        RunError: the design diverges in float64.
    """
    assert result.front is not None  # see front_needed
    assert result.search is not None
    one = result.front.individual(result.search, point)
    _, design, evaluation = next(champion.best_of(result.search, scenario, one))
    if not scenario.robust:
        return design, evaluation, None
    numbers = usable(design, scenario).numbers()
    return _with_use(design, numbers), evaluation, numbers


def _with_use(design: Design, numbers: Json) -> Design:
    return noted(design, {"usable": {key: numbers[key] for key in KEPT}})


def used(scenario: Scenario, result: Result, folder: Path, use: Usable | None = None) -> Json:
    """Return the usability of a run's design as JSON, and write it to the folder.

    ``use`` is the usability, if it is already known.

    Raises:
        RunError: the folder cannot be written.
    """
    known = "usable" in result.design.score  # tested before
    if known and (before := kept_use(folder)) is not None:
        return before
    numbers = (use or usable(result.design, scenario)).numbers()
    if result.design.score.get(LEAST_VIOLATED) and numbers["verdict"] == NO:
        numbers["answer"] = f"no: {NO_DESIGN}: {numbers['answer'].removeprefix('no: ')}"
    checkpoint.write_whole(folder / USABLE, (json.dumps(numbers, indent=1) + "\n").encode())
    return numbers


def kept_use(folder: Path) -> Json | None:
    """Return the stored usability of a run's design, or None; RunError: the file is damaged."""
    return stored.read_numbers(folder / USABLE, stored.UsableFile, _shown)


def _shown(numbers: Json) -> object:
    """Return what pages and the terminal show of the usability."""
    reasons = [reasons_text(one["reasons"]) for one in numbers["motions"].values()]
    of_all, missed = motions_table(numbers, largest=True), missed_text(numbers.get("missed", {}))
    shown = tables(numbers)
    return reasons, of_all, missed, shown, "".join(x for one in shown for x in one.lines)


def _write_design(path: Path, design: Design) -> None:
    checkpoint.write_whole(path, (design_json(design) + "\n").encode())


def finished_run(folder: Path) -> tuple[Scenario, Result]:
    """Return the scenario and the result of a finished run, from its folder.

    Raises:
        UserError: there is no finished run in the folder, or its config or design is damaged.
        RunError: its checkpoint is damaged, made by another run or missing.
    """
    for name in (CONFIG, DESIGN):
        if not (folder / name).exists():
            hint = f"; {resuming(folder)}" if name == DESIGN else ""
            raise UserError(f"{folder}: has no finished run (no {name}){hint}")
    scenario = opened_run(folder)
    config = {CONFIG: stored.made_by(scenario, folder)[CONFIG]}  # to show a run this is enough
    design = read_design(folder / DESIGN)
    number = design.score.get(LAP, 0)
    path = folder / champion.lap_file(CHECKPOINT, number if isinstance(number, int) else 0)
    search = stored.load(path, scenario, config)
    if search is None and not (folder / GIVEN).exists():
        raise RunError(f"{path}: is missing; the search cannot be shown without it")
    front = read_front(scenario, search, folder)
    return scenario, Result(design, evaluate(design, scenario), search, front)


def _save_history(folder: Path, search: Search) -> None:
    lines = ["generation,best,median,diverged,structures"]
    columns = (column.tolist() for column in search.history)
    rows = enumerate(zip(*columns, strict=True))
    lines += [",".join(map(repr, (k, *row))) for k, row in rows]
    checkpoint.write_whole(folder / HISTORY, ("\n".join(lines) + "\n").encode())
