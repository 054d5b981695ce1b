"""Running the cells of a batch: one loop for this process and for workers elsewhere."""

import time
from collections import deque
from collections.abc import Callable, Collection, Iterable
from contextlib import AbstractContextManager, ExitStack, nullcontext, suppress
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

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


#: Files: certificate of the authority, our own certificate, our key; three times None without TLS.
Tls = tuple[Path | None, Path | None, Path | None]


class WorkerOptions(NamedTuple):
    """Processes that run cells at the same time: new ones here, or those of a Dask scheduler."""

    new: int | None  # number of new ones; None: those of the scheduler
    scheduler: str | None = None  # its address
    shared: bool = False  # the workers of the scheduler see the folder of the batch
    tls: Tls = (None, None, None)


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
        """Run the cell in its folder and return its outcome, or return a task that runs it."""
        on_generation = partial(self._on_generation, cell)
        return attempt(partial(design.run, cell.scenario, path, on_generation, self.anyway))

    def done(self, tasks: Collection[Any]) -> Iterable[tuple[Any, Outcome]]:
        """Wait a short time for a task to end; return ended tasks with outcomes of their cells."""
        return ()


def run_batch(
    plan: Plan,
    out: Path,
    on_outcome: Callable[[Cell, Outcome], None],
    workers: WorkerOptions | None = None,
    anyway: bool = False,
    on_generation: Callable[[Cell, Search], None] = lambda cell, search: None,
    on_count: Callable[[int], None] = lambda workers: None,
) -> dict[str, str]:
    """Run every unfinished cell of a plan; return the names of failed cells -> reasons.

    Without ``workers``, cells run here one after the other. ``anyway`` resumes cells that other
    versions of hfc-design began; ``on_count`` gets the number of workers.

    Raises:
        UserError: a cell needs more memory than there is.
        RunError: the folder cannot be written, or the connection to the workers is lost.
    """
    places: AbstractContextManager[Place] = nullcontext(Place(on_generation))
    if workers is not None:
        from hfc_design.batch.cluster import connected

        places = connected(*workers, on_count)
    if at_once := workers.new if workers else 1:
        for cell in plan.cells:
            check_memory(cell.scenario, cell.design, min(at_once, len(plan.cells)))
    folder.note_plan(out, plan)
    with places as place:
        place.anyway = anyway
        return run_cells(out, plan.cells, place, on_outcome)


def run_cells(
    out: Path, cells: Iterable[Cell], place: Place, on_outcome: Callable[[Cell, Outcome], None]
) -> dict[str, str]:
    """Run every unfinished cell; a cell that another process is running is tried again later.

    A cell that fails does not stop the others. Return names of failed cells -> reasons.

    Raises:
        RunError: the folder of the batch cannot be written, or the workers are lost.
    """
    waiting, failed = deque(cells), dict[str, str]()
    running: dict[Any, tuple[Cell, ExitStack]] = {}

    def ended(cell: Cell, outcome: Outcome) -> None:
        if outcome.state == "again":
            waiting.append(cell)
            return
        if outcome.state == "failed":
            failed[cell.name] = outcome.reason
        on_outcome(cell, outcome)

    try:
        while waiting or running:
            before, room = len(waiting) + len(running), place.room()
            for _ in range(len(waiting)):
                if len(running) >= room:
                    break
                cell = waiting.popleft()
                with ExitStack() as claim:
                    started = _started(out, cell, place, claim)
                    if not isinstance(started, Outcome):
                        running[started] = cell, claim.pop_all()
                if isinstance(started, Outcome):
                    ended(cell, started)
            for task, result in place.done(running):
                cell, claim = running.pop(task)
                with claim:
                    outcome = _noted(out, cell, result)
                ended(cell, outcome)
            if not running and len(waiting) == before:
                time.sleep(PATIENCE)
    finally:
        for _, claim in running.values():
            claim.close()
    return failed


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


def _started(out: Path, cell: Cell, place: Place, claim: ExitStack) -> Any:
    """Lock a cell until ``claim`` ends and start it; return its outcome, or its task."""
    path = out / cell.name
    if not claim.enter_context(lock.try_lock(path)):
        return Outcome(state="again")
    if folder.state(out, cell.name) == "finished":
        return Outcome(state="finished")
    folder.note(out, cell.name, "failed", "")  # it is tried again
    tidy(path)
    try:
        if (path / design.CONFIG).exists():  # from an earlier try
            scenario = design.opened_run(path)
        else:
            scenario = design.new_run(cell.scenario, path, cell.design)
        if place.claims:
            claim.close()
        started = place.start(cell._replace(scenario=scenario), path)
    except Lost:
        raise
    except Exception as error:  # whatever it is, the other cells may still be fine
        started = unfinished(error)
    return _noted(out, cell, started) if isinstance(started, Outcome) else started


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
