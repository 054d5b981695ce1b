"""Many runs, for a script, and what they give."""

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path

from hfc_design.batch.findings import Findings
from hfc_design.batch.findings import findings as summed_up
from hfc_design.batch.plan import Cell, read_batch
from hfc_design.batch.report import report
from hfc_design.batch.results import runs_below
from hfc_design.batch.runner import Outcome, Place, run_batch
from hfc_design.core.arguments import check_whole, path_of
from hfc_design.core.overrides import Changes
from hfc_design.core.records import RunError


def batch(
    file: str | Path,
    folder: str | Path | None = None,
    changes: Changes = (),
    *,
    workers: int | None = None,
    anyway: bool = False,
    on_cell: Callable[[Cell, Outcome], None] = lambda cell, outcome: None,
) -> Findings:
    """Run every cell of a batch file that is not finished, and sum up what they gave.

    What ``hfc batch`` does: what broke off goes on where it stopped, what fails stops nothing;
    page and tables are written to the folder.

    Args:
        file: the batch, TOML.
        folder: of its runs; runs/NAME if left out.
        changes: of every cell, by dotted keys.
        workers: processes that run a cell each; without them one cell after the other, each on
            every core. Processes need a script whose work is under ``if __name__ == "__main__"``.
        anyway: go on with cells that other versions of packages or own parts began.
        on_cell: is called with every cell that is done and what became of it.

    Raises:
        UserError: the batch file is not one, or a cell needs more memory than there is.
        RunError: cells failed, after all others have run; ``findings`` tells of them too.
    """
    if workers is not None:
        check_whole("--workers", workers, 1)
    plan = read_batch(path_of(file), changes)
    out = plan.folder(None if folder is None else path_of(folder))
    places: AbstractContextManager[Place] = nullcontext(Place())
    if workers is not None:
        from hfc_design.batch.cluster import connected

        places = connected(workers, None, False, (None, None, None), lambda count: None)
    failed = run_batch(plan, out, workers or 1, places, anyway, on_cell)
    report(out, tell=lambda page, findings: None)
    if failed:
        reasons = "; ".join(f"{name}: {reason}" for name, reason in failed.items())
        raise RunError(f"{out}: {len(failed)} of {len(plan.cells)} cells failed: {reasons}")
    return findings(out)


def findings(folder: str | Path) -> Findings:
    """What the runs below a folder give: groups over the seeds, their structures, how they compare.

    Raises:
        UserError: there is no such folder, or no run in it.
    """
    place = path_of(folder)
    return summed_up(place, runs_below(place))
