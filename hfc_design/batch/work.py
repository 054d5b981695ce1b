"""Running the cells of a batch, one after the other; each uses every core."""

import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from hfc_design import design
from hfc_design.batch import folder
from hfc_design.batch.plan import Cell
from hfc_design.records import RunError
from hfc_design.scenarios import Scenario
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


def finish(scenario: Scenario, path: Path, on_generation: Callable[[Search], None]) -> None:
    """Run a cell to its end in its run folder, from where an earlier try broke off."""
    if (path / design.CONFIG).exists():
        own = design.opened_run(path)
    else:
        own = design.new_run(scenario, path)
    design.run(own, path, on_generation)


def _tried(out: Path, cell: Cell, on_generation: Callable[[Cell, Search], None]) -> Outcome:
    if folder.state(out, cell.name) == "finished":  # by another batch, since we looked
        return Outcome(cell, "finished")
    begun = time.monotonic()
    folder.forget_failure(out, cell.name)
    try:
        finish(cell.scenario, out / cell.name, lambda search: on_generation(cell, search))
    except Exception as error:  # whatever it is, the other cells may still be fine
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        with suppress(RunError):  # a full disk takes no notes either
            folder.note(out, cell.name, "failed", reason)
        return Outcome(cell, "failed", reason)
    seconds = time.monotonic() - begun
    folder.note(out, cell.name, "seconds", f"{seconds:.3f}")
    return Outcome(cell, "finished", seconds=seconds)
