"""``hfc report``: pages of single runs, page and tables of many."""

import sys
from contextlib import nullcontext
from pathlib import Path

from hfc_design.batch import folder, tables
from hfc_design.batch.page import page
from hfc_design.batch.published import findings
from hfc_design.batch.runs import Run, batches_below, is_run, runs_below
from hfc_design.core.checkpoint import write_whole
from hfc_design.core.records import RunError, UserError
from hfc_design.report import REPORT
from hfc_design.report.page import write_page
from hfc_design.runs.run import finished_run


def report(path: Path, each: bool = False, parquet: bool = False) -> None:
    """Write the page of a run, or page and tables of all runs below a folder.

    Raises:
        UserError: there is no run, or none that has finished where one is needed.
        RunError: a page could not be written.
    """
    if is_run(path):
        if each or parquet:
            raise UserError(f"{path}: is a run; --each and --parquet are for folders of runs")
        write_page(*finished_run(path), path)
        print(path / REPORT)
        return
    with folder.reporting(path) if (path / folder.PLAN).exists() else nullcontext():
        failed = _write_all(path, each, parquet)
    print(path / REPORT)
    if failed:
        raise RunError(f"{failed} of the runs got no page of their own")


def _write_all(path: Path, each: bool, parquet: bool) -> int:
    """Page and tables; returns how many runs got no page of their own though they should."""
    runs = runs_below(path)
    failed = 0
    if each:
        failed = _write_missing(path, runs)
        runs = runs_below(path)
    found = findings(path, runs)
    tables.write(path, found, parquet)
    told = [text for batch in batches_below(path) for text in folder.descriptions(batch)]
    write_whole(path / REPORT, page(path.resolve().name, told, found))
    return failed


def _write_missing(path: Path, runs: list[Run]) -> int:
    """Write the pages that finished runs lack; returns how many could not be."""
    missing = [run for run in runs if run.state == "finished" and not run.page]
    failed = 0
    for k, run in enumerate(missing, 1):
        place = path / run.path
        try:
            write_page(*finished_run(place), place)
            print(f"page {k}/{len(missing)}  {place / REPORT}", file=sys.stderr)
        except UserError as error:
            failed += 1
            print(f"page {k}/{len(missing)}  {error}", file=sys.stderr)
    return failed
