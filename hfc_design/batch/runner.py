"""Running the cells of a batch: one loop for this process and for workers elsewhere."""

import time
from collections import deque
from collections.abc import Callable, Collection, Iterable
from contextlib import AbstractContextManager, ExitStack, suppress
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field

from hfc_design.batch import folder
from hfc_design.batch.plan import Cell, Plan
from hfc_design.core import lock
from hfc_design.core.checkpoint import tidy, write_whole
from hfc_design.core.records import LONGEST, NotNegative, Record, RunError, UserError, in_a_line
from hfc_design.runs import run as design
from hfc_design.runs.problem import check_memory
from hfc_design.search.loop import Search

#: Seconds between checks of cells that other batches are running.
PATIENCE = 0.5
#: Pattern of the names of files that a worker may return: those that a run writes.
WRITTEN = r"^((checkpoint(-\d{1,3})?|polish)\.npz|(history|front)\.csv|(design|usable)\.json)$"


class Outcome(Record):
    """Outcome of an attempt to run a cell; "again": another process runs it, or it was stopped."""

    state: Literal["finished", "failed", "again"]
    reason: Annotated[str, Field(max_length=LONGEST)] = ""  # why it is not finished
    seconds: NotNegative = 0.0  # duration of the attempt; 0 if the cell was finished before
    #: Files of its run folder that a remote worker has returned.
    files: dict[
        Annotated[str, Field(pattern=WRITTEN)], Annotated[bytes, Field(max_length=2**30)]
    ] = {}


class Left(Exception):
    """Leave the cell: its result is no longer awaited, or the worker has to stop."""


class Lost(RunError):
    """The connection to the place is lost, and the state of its cells is unknown."""


class Place:
    """Place where cells run; in this class it is this process, with one cell at a time."""

    #: True if the process that runs a cell has access to the batch's folder and locks the cell.
    claims = False
    #: True if cells that other versions of hfc-design began are continued.
    anyway = False

    def __init__(self, on_generation: Callable[[Cell, Search], None] = lambda cell, search: None):
        self._on_generation = on_generation

    def room(self) -> int:
        """Number of cells that can run at once."""
        return 1

    def start(self, cell: Cell, path: Path) -> Any:
        """Return a task that runs the cell in its folder; in this class ``done`` runs it."""
        on_generation = partial(self._on_generation, cell)
        return partial(
            attempt, partial(design.run, cell.scenario, path, on_generation, self.anyway)
        )

    def done(self, tasks: Collection[Any]) -> Iterable[tuple[Any, Outcome]]:
        """Return finished tasks with the outcomes of their cells; in this class run all tasks."""
        return [(task, task()) for task in tasks]


def run_batch(
    plan: Plan,
    out: Path,
    at_once: int,
    places: AbstractContextManager[Place],
    anyway: bool,
    on_outcome: Callable[[Cell, Outcome], None],
) -> dict[str, str]:
    """Run every unfinished cell of a plan; return the names of failed cells -> reasons.

    ``at_once`` is the number of cells that run on this machine at a time (0: none), for the check
    of the memory; ``anyway`` resumes cells that other versions of hfc-design began.

    Raises:
        UserError: a cell needs more memory than there is.
        RunError: the folder cannot be written, or the connection to the workers is lost.
    """
    for cell in plan.cells if at_once else ():
        check_memory(cell.scenario, cell.design, min(at_once, len(plan.cells)))
    folder.note_plan(out, plan)
    failed: dict[str, str] = {}

    def outcome(cell: Cell, result: Outcome) -> None:
        if result.state == "failed":
            failed[cell.name] = result.reason
        on_outcome(cell, result)

    with places as place:
        place.anyway = anyway
        run_cells(out, plan.cells, place, outcome)
    return failed


def run_cells(
    out: Path, cells: Iterable[Cell], place: Place, on_outcome: Callable[[Cell, Outcome], None]
) -> None:
    """Run every unfinished cell; a cell that another process is running is tried again later.

    A cell that fails does not stop the others.

    Raises:
        RunError: the folder of the batch cannot be written, or the workers are lost.
    """
    waiting = deque(cells)
    running: dict[Any, tuple[Cell, ExitStack]] = {}
    try:
        while waiting or running:
            ended: list[tuple[Cell, Outcome]] = []
            room = place.room()
            while waiting and len(running) < room:
                cell = waiting.popleft()
                started = _started(out, cell, place)
                if isinstance(started, Outcome):
                    ended.append((cell, started))
                else:
                    task, claim = started
                    running[task] = cell, claim
            for task, outcome in place.done(running):
                cell, claim = running.pop(task)
                with claim:
                    ended.append((cell, _noted(out, cell, outcome)))
            for cell, outcome in ended:
                if outcome.state == "again":
                    waiting.append(cell)
                else:
                    on_outcome(cell, outcome)
            if waiting and not running and all(outcome.state == "again" for _, outcome in ended):
                time.sleep(PATIENCE)
    finally:
        for _, claim in running.values():
            claim.close()


def attempt(work: Callable[[], object]) -> Outcome:
    """Do the work of a cell and return its outcome."""
    start = time.monotonic()
    try:
        work()
    except Exception as error:  # whatever it is, the other cells may still be fine
        return unfinished(error)
    return Outcome(state="finished", seconds=time.monotonic() - start)


def unfinished(error: Exception, where: str = "") -> Outcome:
    """Return the outcome of a cell that ended with an error; ``where`` begins its reason."""
    state = "again" if isinstance(error, Left | lock.Overtaken) else "failed"
    fault = error.typed if isinstance(error, UserError) else error
    reason = in_a_line(f"{type(error).__name__}: {fault}")
    return Outcome(state=state, reason=in_a_line(where + reason))


def _started(out: Path, cell: Cell, place: Place) -> Outcome | tuple[Any, ExitStack]:
    """Start a cell; return its task and our lock of it, or its outcome if it does not start."""
    path = out / cell.name
    with ExitStack() as claim:
        if not claim.enter_context(lock.try_lock(path)):
            return Outcome(state="again")
        if folder.state(out, cell.name) == "finished":
            return Outcome(state="finished")
        folder.forget_failure(out, cell.name)
        tidy(path)
        try:
            if (path / design.CONFIG).exists():  # from an earlier try
                scenario = design.opened_run(path)
            else:
                scenario = design.new_run(cell.scenario, path, cell.design)
            if place.claims:
                claim.close()
            return place.start(cell._replace(scenario=scenario), path), claim.pop_all()
        except Lost:
            raise
        except Exception as error:  # whatever it is, the other cells may still be fine
            return _noted(out, cell, unfinished(error))


def _noted(out: Path, cell: Cell, outcome: Outcome) -> Outcome:
    """Store the files of an outcome, and note why the cell failed or how long it took."""
    try:
        for name in sorted(outcome.files, key=lambda name: name == design.DESIGN):  # design last
            write_whole(out / cell.name / name, outcome.files[name])
    except RunError as error:
        outcome = unfinished(error)
    if outcome.state == "failed":
        with suppress(RunError):  # on a full disk this fails too
            folder.note(out, cell.name, "failed", outcome.reason)
    elif outcome.state == "finished" and outcome.seconds:
        folder.note(out, cell.name, "seconds", f"{outcome.seconds:.3f}")
    return outcome
