"""Running the cells of a batch, one after the other; each uses every core."""

import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from hfc_design.batch import folder
from hfc_design.batch.plan import Cell
from hfc_design.core.records import RunError
from hfc_design.files.scenario import Scenario
from hfc_design.runs import run as design
from hfc_design.search.loop import Search

#: Seconds between looks at a cell that another batch is at.
PATIENCE = 0.5


class Outcome(NamedTuple):
    """What became of a cell just now."""

    cell: Cell
    state: folder.State
    reason: str = ""
    seconds: float = 0.0


def run_cells(
    out: Path,
    cells: Sequence[Cell],
    on_outcome: Callable[[Outcome], None],
    on_generation: Callable[[Cell, Search], None] = lambda cell, search: None,
) -> None:
    """Finish every cell that is not, those that another batch is at last of all.

    A cell that fails does not stop the others. Raises:
        RunError: the folder of the batch cannot be written.
    """
    waiting = list(cells)
    while waiting:
        busy = []
        for cell in waiting:
            if folder.state(out, cell.name) == "finished":
                on_outcome(Outcome(cell, "finished"))
                continue
            with folder.claimed(out, cell.name) as mine:
                if mine:
                    on_outcome(_tried(out, cell, on_generation))
                else:
                    busy.append(cell)
        waiting = busy
        if busy:
            time.sleep(PATIENCE)


def begun(cell: Cell, path: Path) -> Scenario:
    """The cell's run folder, new or from an earlier try; returns the scenario that it holds.

    Raises:
        UserError: the folder holds no run, or cannot be written.
    """
    if (path / design.CONFIG).exists():
        return design.opened_run(path)
    return design.new_run(cell.scenario, path, cell.design)


def told(error: Exception) -> str:
    """Why a cell failed, in one line."""
    line = " ".join(f"{type(error).__name__}: {error}".split())
    return "".join(letter if letter.isprintable() else "?" for letter in line)


def failed(out: Path, cell: Cell, reason: str) -> Outcome:
    """Note a failure."""
    with suppress(RunError):  # a full disk takes no notes either
        folder.note(out, cell.name, "failed", reason)
    return Outcome(cell, "failed", reason)


def finished(out: Path, cell: Cell, seconds: float) -> Outcome:
    """Note how long a finished cell took."""
    folder.note(out, cell.name, "seconds", f"{seconds:.3f}")
    return Outcome(cell, "finished", seconds=seconds)


def _tried(out: Path, cell: Cell, on_generation: Callable[[Cell, Search], None]) -> Outcome:
    if folder.state(out, cell.name) == "finished":  # by another batch, since we looked
        return Outcome(cell, "finished")
    start = time.monotonic()
    folder.forget_failure(out, cell.name)
    path = out / cell.name
    try:
        own = begun(cell, path)
        design.run(own, path, lambda search: on_generation(cell, search))
    except Exception as error:  # whatever it is, the other cells may still be fine
        return failed(out, cell, told(error))
    return finished(out, cell, time.monotonic() - start)
