"""Terminal output of ``hfc batch``: the plan, the progress, the outcome."""

import json
import statistics
import sys
from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import islice
from pathlib import Path

from hfc_design.batch import folder, report
from hfc_design.batch.plan import Cell, Plan
from hfc_design.batch.results import listed
from hfc_design.batch.runner import Outcome, WorkerOptions, run_batch
from hfc_design.core.console import ProgressBar, show
from hfc_design.core.records import RunError, harmless
from hfc_design.core.tables import Table
from hfc_design.files.labels import PLAN, run_labels, shared
from hfc_design.search.loop import Search

#: Assumed time steps times individuals per second, until a cell has finished.
USUAL_SPEED = 2e7
#: Seconds to score a given design, after compilation.
SCORING = 0.3
#: Seconds to compile a program; cells that differ only in seed or generations share one.
COMPILING = 5.0
#: Largest number of cells that are listed one by one.
LISTED = 40


def run(plan: Plan, out: Path, workers: WorkerOptions | None, anyway: bool) -> None:
    """Run every unfinished cell, here or on workers, and report; see ``run_batch``.

    Raises:
        UserError: a cell needs more memory than there is.
        RunError: cells failed, or the batch was interrupted.
    """
    cells, watch = plan.cells, Watch(plan.cells)
    options = (watch.outcome, workers, anyway, watch.generation, watch.workers)
    try:
        with watch:
            failed = run_batch(plan, out, *options)
    except KeyboardInterrupt:
        raise RunError("interrupted; run the same command again to continue") from None
    print(f"{len(cells)} cells in {out}: {len(cells) - len(failed)} finished, {len(failed)} failed")
    for reason in dict.fromkeys(failed.values()):
        alike = [watch.names[name] or name for name, why in failed.items() if why == reason]
        print(f"{'; '.join(alike)}: {reason}", file=sys.stderr)
    report.report(out)
    if failed:
        raise RunError(f"{len(failed)} of {len(cells)} cells failed")


def show_status(out: Path) -> None:
    """``hfc batch --status DIR``: print the count of each state, and the unfinished cells."""
    cells = folder.entries(out)
    seconds = [entry.seconds for entry in cells if entry.seconds is not None]
    print(f"{len(cells)} cells in {out}: {listed(Counter(entry.state for entry in cells))}")
    if seconds:
        print(f"median time of a finished cell {statistics.median(seconds):.2g} s")
    left = [entry for entry in cells if entry.state != "finished"]
    if left:
        labels = run_labels({entry.name: entry.settings for entry in cells})
        reasons = [f"{labels[x.name]}: {x.reason}" for x in left[:LISTED] if x.reason]
        _show(((labels[x.name], x.state, x.name) for x in left), reasons)


def _show(cells: Iterable[tuple[str, str, str]], lines: Sequence[str] = ()) -> None:
    show(Table("", ("cell", "state", "folder"), [*islice(cells, LISTED)], lines=lines))


def show_plan(cells: list[Cell], out: Path) -> None:
    """``hfc batch FILE --dry-run``: print the state of each cell, and the expected time."""
    states = {cell.name: folder.state(out, cell.name) for cell in cells}
    same = shared(cell.settings for cell in cells)
    labels = run_labels({cell.name: cell.settings for cell in cells})
    alike = harmless(", ".join(f"{key}={value}" for key, value in same.items()))
    print(f"{len(cells)} cells in {out}" + (f", all with {alike}" if same else ""))
    _show((labels[name], state, name) for name, state in states.items())
    if len(cells) > LISTED:
        print(f"and {len(cells) - LISTED} more")
    left = [cell for cell in cells if states[cell.name] != "finished"]
    speed, source = _speed(cells, out)
    seconds = sum(SCORING if cell.design else _work(cell) / speed for cell in left)
    compiling = COMPILING * len({_program(cell) for cell in left})
    hours, rest = divmod(round(seconds + compiling), 3600)
    print(
        f"{len(cells) - len(left)} of them finished; about {hours} h {rest // 60:02d} "
        f"min {rest % 60:02d} s to go ({source}), {compiling:.0f} s of it to compile"
    )


def _speed(cells: list[Cell], out: Path) -> tuple[float, str]:
    """Return time steps times individuals per second, and a text on the origin of this number."""
    if (out / PLAN).exists():
        seconds = {e.name: e.seconds for e in folder.entries(out) if e.seconds}
        searched = [cell for cell in cells if cell.name in seconds and not cell.design]
        known = [_work(cell) / seconds[cell.name] for cell in searched]
        if known:
            return statistics.median(known), f"as fast as the {len(known)} finished ones"
    return USUAL_SPEED, f"at {USUAL_SPEED:.0e} individual-steps/s, a guess until one has finished"


def _work(cell: Cell) -> float:
    search, scenario = cell.scenario.search, cell.scenario
    return search.population * search.generations * scenario.simulation.steps


def _program(cell: Cell) -> str:
    """Return a key of the compiled program of a cell: all settings but seed and generations."""
    settings = cell.scenario.model_dump(mode="json", exclude={"run": {"seed"}})
    settings["search"].pop("generations", None)
    return json.dumps([settings, cell.design is None], default=str)


class Watch(ProgressBar):
    """Progress display: the finished cells, and the running one or the number of workers."""

    def __init__(self, cells: list[Cell]):
        super().__init__("cells", len(cells))
        self.names = run_labels({cell.name: cell.settings for cell in cells})
        self._done, self._waited = 0, False

    def generation(self, cell: Cell, search: Search) -> None:
        """Show the progress of the running cell."""
        self.show(
            line=f"generation {search.generation}/{cell.scenario.search.generations}  "
            f"best {search.history.best[-1]:.5g}  {cell.scenario.name}  {self.names[cell.name]}"
        )

    def workers(self, count: int) -> None:
        """Show the number of workers; if there are none, say once that the batch waits."""
        self.show(line=f"{count} workers")
        if not (count or self._waited):
            self._waited = True
            self.console.print("waiting for workers")

    def outcome(self, cell: Cell, outcome: Outcome) -> None:
        """Count a finished cell."""
        self._done += 1
        self.show(completed=self._done)
        if outcome.seconds or outcome.reason:
            said = outcome.reason or f"{outcome.seconds:.1f} s"
            self.say(f"cell {self._done}/{self.total}  {self.names[cell.name]}  {said}")
