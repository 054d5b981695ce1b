"""What ``hfc batch`` says: the plan, the progress, the outcome."""

import statistics
import sys
from collections import defaultdict
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeRemainingColumn
from rich.table import Table

from hfc_design.batch import folder, report
from hfc_design.batch.plan import LABEL, Cell, read_batch
from hfc_design.batch.runs import counted
from hfc_design.batch.work import Outcome, run_cells
from hfc_design.core.console import column, terminal
from hfc_design.core.records import RunError
from hfc_design.search.loop import Search

#: Individual-steps a second that a plan is estimated with before any cell has run.
USUAL_SPEED = 2e7
#: Seconds that it takes to score a given design, once compiled.
SCORING = 0.3
#: Seconds for the first compilation.
COMPILING = 5.0
#: So many cells are listed one by one.
LISTED = 40


class Where(NamedTuple):
    """Where cells run that do not run in this process."""

    workers: int | None  # processes of this machine, or else
    scheduler: str | None  # address of a Dask scheduler
    shared: bool  # whether its workers see the batch's folder


def batch(
    path: Path, out: Path | None, dry_run: bool, where: Where | None, changes: Iterable[str]
) -> None:
    """``hfc batch FILE``: run every cell that is not finished, here or ``where``; report.

    ``changes`` of dotted keys are laid over every cell.

    Raises:
        UserError: the batch file is not one.
        RunError: cells failed, or the batch was interrupted.
    """
    plan = read_batch(path, changes)
    cells, target = plan.cells, out or Path("runs") / plan.name
    if dry_run:
        _show_plan(cells, target)
        return
    folder.note_plan(target, plan)
    watch = Watch(cells)
    try:
        with watch:
            if where is None:
                run_cells(target, cells, watch.outcome, watch.generation)
            else:
                _on_workers(where, target, cells, watch)
    except KeyboardInterrupt:
        raise RunError("interrupted; the same command goes on where it stopped") from None
    print(f"{len(cells)} cells in {target}: {watch.finished} finished, {len(watch.failed)} failed")
    for outcome in watch.failed:
        print(f"{outcome.cell.name}: {outcome.reason}", file=sys.stderr)
    report.report(target)
    if watch.failed:
        raise RunError(f"{len(watch.failed)} of {len(cells)} cells failed")


def _on_workers(where: Where, target: Path, cells: list[Cell], watch: "Watch") -> None:
    from hfc_design.batch import cluster

    shared = where.scheduler is None or where.shared
    with cluster.connected(where.workers, where.scheduler) as client:
        cluster.run_cells(client, target, cells, watch.outcome, watch.workers, shared)


def show_status(out: Path) -> None:
    """``hfc batch --status DIR``: what became of every cell."""
    found = folder.entries(out)
    seconds = [entry.seconds for entry in found if entry.seconds is not None]
    print(f"{len(found)} cells in {out}: {counted(entry.state for entry in found)}")
    if seconds:
        print(f"median time of a finished cell {statistics.median(seconds):.2g} s")
    table = Table("cell", "state", "settings", box=None)
    for entry in [entry for entry in found if entry.state != "finished"][:LISTED]:
        table.add_row(entry.name, entry.state, _told(entry.settings) + f"\n{entry.reason}".rstrip())
    if table.row_count:
        terminal().print(table)


def _show_plan(cells: list[Cell], out: Path) -> None:
    states = [folder.state(out, cell.name) for cell in cells]
    same, apart = _same(cells), _apart(cells)
    print(f"{len(cells)} cells in {out}" + (f", all with {_told(same)}" if same else ""))
    table = Table("cell", "state", "settings", box=None)
    for cell, state in list(zip(cells, states, strict=True))[:LISTED]:
        table.add_row(cell.name, state, _told(apart[cell.name]))
    terminal().print(table)
    if len(cells) > LISTED:
        print(f"and {len(cells) - LISTED} more")
    left = [cell for cell, state in zip(cells, states, strict=True) if state != "finished"]
    speed, source = _speed(cells, out)
    seconds = sum(SCORING if cell.design else _work(cell) / speed for cell in left)
    seconds += COMPILING if left else 0.0
    hours, rest = divmod(round(seconds), 3600)
    print(
        f"{len(cells) - len(left)} of them finished; about {hours} h {rest // 60:02d} "
        f"min {rest % 60:02d} s to go ({source})"
    )


def _same(cells: list[Cell]) -> dict[str, object]:
    """The settings that every cell has."""
    first, *others = (cell.settings for cell in cells)
    return {
        key: value
        for key, value in first.items()
        if all(key in own and own[key] == value for own in others)
    }


def _apart(cells: list[Cell]) -> dict[str, dict[str, object]]:
    """What sets each cell apart from the others; of a label what differs inside it."""
    labelled: dict[object, list[Cell]] = defaultdict(list)
    for cell in cells:
        labelled[cell.settings.get(LABEL)].append(cell)
    found = {}
    for label, inside in labelled.items():
        same = _same(cells if label is None else inside)
        for cell in inside:
            own = {key: value for key, value in cell.settings.items() if key not in same}
            found[cell.name] = own if label is None else {LABEL: label} | own
    return found


def _speed(cells: list[Cell], out: Path) -> tuple[float, str]:
    """Individual-steps a second, and where that number comes from."""
    if (out / folder.PLAN).exists():
        seconds = {e.name: e.seconds for e in folder.entries(out) if e.seconds}
        searched = [cell for cell in cells if cell.name in seconds and not cell.design]
        known = [_work(cell) / seconds[cell.name] for cell in searched]
        if known:
            return statistics.median(known), f"as fast as the {len(known)} finished ones"
    return USUAL_SPEED, f"at {USUAL_SPEED:.0e} individual-steps/s, a guess until one has finished"


def _work(cell: Cell) -> float:
    search, scenario = cell.scenario.search, cell.scenario
    return search.population * search.generations * scenario.simulation.steps


def _told(settings: dict[str, object]) -> str:
    return ", ".join(f"{key}={value}" for key, value in settings.items())


class Watch:
    """A bar on a terminal, a line a cell elsewhere; both on stderr."""

    def __init__(self, cells: list[Cell]):
        self._console = terminal(stderr=True)
        self._bar = Progress(
            column("cells"),
            BarColumn(bar_width=20),
            MofNCompleteColumn(),
            column("{task.fields[line]}"),
            TimeRemainingColumn(),
            console=self._console,
            disable=not self._console.is_terminal,
        )
        self._task = self._bar.add_task("cells", total=len(cells), line="")
        self._total, self._done, self._apart = len(cells), 0, _apart(cells)
        self.finished = 0
        self._waited = False
        self.failed: list[Outcome] = []

    def __enter__(self) -> "Watch":
        self._bar.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._bar.stop()

    def generation(self, cell: Cell, search: Search) -> None:
        """Show where the running cell is."""
        line = (
            f"{cell.name} {cell.scenario.name} generation {search.generation}/"
            f"{cell.scenario.search.generations} best {search.history.best[-1]:.5g}"
        )
        self._bar.update(self._task, line=line)

    def workers(self, count: int) -> None:
        """Show how many workers there are; without any a batch waits."""
        self._bar.update(self._task, line=f"{count} workers")
        if not (count or self._waited):
            self._waited = True
            self._console.print("waiting for workers")

    def outcome(self, outcome: Outcome) -> None:
        """Count a cell that is done."""
        self._done += 1
        if outcome.state == "failed":
            self.failed.append(outcome)
        else:
            self.finished += 1
        self._bar.update(self._task, completed=self._done)
        if not self._console.is_terminal and (outcome.seconds or outcome.reason):
            told = outcome.reason or f"{outcome.seconds:.1f} s"
            place = f"cell {self._done}/{self._total}  {outcome.cell.name}"
            own = _told(self._apart[outcome.cell.name])
            print(f"{place}  {own}  {told}", file=sys.stderr)
