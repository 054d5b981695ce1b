"""Batches of runs from a script, and the summary of their results."""

from collections.abc import Callable
from pathlib import Path

from hfc_design.batch.findings import Findings
from hfc_design.batch.findings import findings as summed_up
from hfc_design.batch.plan import Cell, read_batch
from hfc_design.batch.report import report
from hfc_design.batch.runner import Outcome, WorkerOptions, run_batch
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
    """Run every unfinished cell of a batch file and summarise the results.

    The counterpart of ``hfc batch``: interrupted cells continue where they stopped, a failed cell
    does not stop the others, and the page and the tables are written to the folder.

    Args:
        file: path of the batch file (TOML).
        folder: folder of the runs; default: runs/NAME.
        changes: changes to every cell, by dotted keys.
        workers: number of processes, each of which runs one cell at a time; default: one cell after
            the other, each on every core. With processes, the work of the script must be under
            ``if __name__ == "__main__"``.
        anyway: continue cells that were started by other versions of packages or of own parts.
        on_cell: function called with every cell that is done and its outcome.

    Returns:
        The findings of the folder, as ``findings`` returns them.

    Raises:
        UserError: the file is not a valid batch file, or a cell needs more memory than there is.
        RunError: cells failed; raised after all other cells have run, and ``findings`` includes the
            failed ones.
    """
    if workers is not None:
        check_whole("workers", workers, 1)
    plan = read_batch(path_of(file), changes)
    out = plan.folder(None if folder is None else path_of(folder))
    options = None if workers is None else WorkerOptions(workers)
    failed = run_batch(plan, out, on_cell, options, anyway)
    report(out, quiet=True)
    if failed:
        reasons = "; ".join(f"{name}: {reason}" for name, reason in failed.items())
        raise RunError(f"{out}: {len(failed)} of {len(plan.cells)} cells failed: {reasons}")
    return findings(out)


def findings(folder: str | Path) -> Findings:
    """Summarise the runs below a folder: groups over the seeds, their structures and comparisons.

    Raises:
        UserError: the folder does not exist or contains no run.
    """
    return summed_up(path_of(folder))
