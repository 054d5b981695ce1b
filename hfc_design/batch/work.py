"""Running the cells of a batch: one loop for this process and for workers elsewhere."""

import time
from collections import deque
from collections.abc import Callable, Collection, Iterable, Mapping
from contextlib import ExitStack, suppress
from functools import partial
from pathlib import Path
from typing import Any, Literal, NamedTuple

from hfc_design.batch import folder
from hfc_design.batch.plan import Cell, Plan
from hfc_design.core.checkpoint import tidy, write_whole
from hfc_design.core.lock import Overtaken
from hfc_design.core.records import RunError, UserError, in_a_line
from hfc_design.runs import run as design
from hfc_design.runs.problem import check_memory
from hfc_design.search.loop import Search

#: Seconds between looks at cells that other batches are at.
PATIENCE = 0.5


class Outcome(NamedTuple):
    """What became of a cell just now; "again" is one that somebody else is at, or had to leave."""

    state: Literal["finished", "failed", "again"]
    reason: str = ""  # why it is not finished
    seconds: float = 0.0  # that it took; 0 if another batch has finished it
    files: Mapping[str, bytes] = {}  # of its run folder, by their names, that came from afar


class Left(Exception):
    """Nobody waits for the cell any more, or the worker has to stop."""


class Lost(RunError):
    """The place can no longer be reached, and what its cells do is not known."""


class Place:
    """Where cells run: this process, one cell after the other, each on every core."""

    #: Whether who runs a cell sees the folder of the batch and claims the cell himself.
    claims = False
    #: Whether a cell goes on that other versions began.
    anyway = False

    def __init__(self, on_generation: Callable[[Cell, Search], None] = lambda cell, search: None):
        self._on_generation = on_generation

    def room(self) -> int:
        """How many cells can run at once."""
        return 1

    def start(self, cell: Cell, path: Path) -> Any:
        """A task that runs the cell in its folder; here it does when its outcome is asked for."""
        on_generation = partial(self._on_generation, cell)
        work = partial(design.run, cell.scenario, path, on_generation, self.anyway)
        return partial(attempt, work)

    def done(self, tasks: Collection[Any]) -> Iterable[tuple[Any, Outcome]]:
        """Tasks that are done and what became of their cells; waits a little for the first."""
        return [(task, task()) for task in tasks]


def begin(plan: Plan, out: Path, at_once: int) -> None:
    """Note the cells in the folder, of which so many will run at once here; 0: none will.

    Raises:
        UserError: a cell needs more memory than there is.
        RunError: the folder cannot be written.
    """
    for cell in plan.cells if at_once else ():
        check_memory(cell.scenario, cell.design, min(at_once, len(plan.cells)))
    folder.note_plan(out, plan)


def run_cells(
    out: Path, cells: Iterable[Cell], place: Place, on_outcome: Callable[[Cell, Outcome], None]
) -> None:
    """Finish every cell that is not, those that another batch is at last of all.

    A cell that fails does not stop the others. Raises:
        RunError: the folder of the batch cannot be written, or the place is lost.
    """
    waiting = deque(cells)
    running: dict[Any, tuple[Cell, ExitStack]] = {}
    try:
        while waiting or running:
            ended: list[tuple[Cell, Outcome]] = []
            room = place.room()
            while waiting and len(running) < room:
                cell = waiting.popleft()
                found = _started(out, cell, place)
                if isinstance(found, Outcome):
                    ended.append((cell, found))
                else:
                    task, claim = found
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
            if waiting and not running and all(found.state == "again" for _, found in ended):
                time.sleep(PATIENCE)
    finally:
        for _, claim in running.values():
            claim.close()


def attempt(work: Callable[[], object]) -> Outcome:
    """Do the work on a cell."""
    start = time.monotonic()
    try:
        work()
    except Exception as error:  # whatever it is, the other cells may still be fine
        return _unfinished(error)
    return Outcome("finished", seconds=time.monotonic() - start)


def _unfinished(error: Exception) -> Outcome:
    return Outcome("again" if isinstance(error, Left | Overtaken) else "failed", told(error))


def told(error: Exception) -> str:
    """Why a cell failed, in one line."""
    fault = error.typed if isinstance(error, UserError) else error
    return in_a_line(f"{type(error).__name__}: {fault}")


def _started(out: Path, cell: Cell, place: Place) -> Outcome | tuple[Any, ExitStack]:
    """The task of a cell and our claim of it, or what became of the cell without one."""
    path = out / cell.name
    with ExitStack() as claim:
        if not claim.enter_context(folder.claimed(out, cell.name)):
            return Outcome("again")
        if folder.state(out, cell.name) == "finished":
            return Outcome("finished")
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
            return _noted(out, cell, _unfinished(error))


def _noted(out: Path, cell: Cell, found: Outcome) -> Outcome:
    """Keep what has come from afar, and note why a cell failed or how long it took."""
    try:
        order = sorted(found.files, key=lambda name: name == design.DESIGN)  # that finishes it
        for name in order:
            write_whole(out / cell.name / name, found.files[name])
    except RunError as error:
        found = _unfinished(error)
    if found.state == "failed":
        with suppress(RunError):  # a full disk takes no notes either
            folder.note(out, cell.name, "failed", found.reason)
    elif found.state == "finished" and found.seconds:
        folder.note(out, cell.name, "seconds", f"{found.seconds:.3f}")
    return found
