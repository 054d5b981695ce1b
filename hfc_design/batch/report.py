"""``hfc report``: pages of single runs; page and full-precision tables of several runs."""

import io
import sys
from collections.abc import Iterable, Sequence
from contextlib import nullcontext
from pathlib import Path

from hfc_design.batch import folder
from hfc_design.batch.findings import Comparison, Findings, Group, Reproduced, Winner, findings
from hfc_design.batch.page import page
from hfc_design.batch.results import JUDGED_BY, MARGINS, Run, is_run, runs_below, text
from hfc_design.batch.summary import STRUCTURES, tables
from hfc_design.core.checkpoint import write_whole
from hfc_design.core.console import busy, show
from hfc_design.core.numbers import Json
from hfc_design.core.records import RunError, UserError, option
from hfc_design.files.labels import PLAN
from hfc_design.formats.writing import csv_text
from hfc_design.report import REPORT
from hfc_design.report.page import write_page
from hfc_design.report.paper import Paper, write_with_parts
from hfc_design.runs.run import finished_run

RUNS, GROUPS, COMPARISONS, PARQUET = "runs.csv", "groups.csv", "comparisons.csv", "runs.parquet"
PUBLISHED = "published.csv"
Column = list[str | int | float | None]
Rows = Iterable[Sequence[object]]
QUARTILES = ("lower_quartile", "median", "upper_quartile")


def report(
    path: Path,
    each: bool = False,
    parquet: bool = False,
    paper: Paper | None = None,
    quiet: bool = False,
) -> None:
    """Write the page of a run, or page and tables of all runs below a folder.

    ``each`` also writes the missing pages of finished runs, ``parquet`` also a table as Parquet.
    ``paper`` selects parts of the page that are also written as files for a paper. Unless
    ``quiet``, the findings of several runs and the path of the page are printed.

    Raises:
        UserError: there is no run, a single run is not finished, or ``parquet`` lacks pyarrow.
        RunError: a page could not be written.
    """
    shown, failed = [], 0
    with nullcontext() if quiet else busy("writing the pages"):
        if is_run(path):
            if each or parquet:
                options = f"{option('each', True)} and --parquet"
                raise UserError(f"{path}: is a run; {options} are for folders of runs")
            write_page(*finished_run(path), path, paper=paper)
        else:
            batch = (path / PLAN).exists()  # only one process at a time may write its report
            with folder.waited(path, "report") if batch else nullcontext():
                failed = _write_missing(path, runs_below(path)) if each else 0
                found = findings(path)
                _write_tables(path, found, parquet)
                write_with_parts(path / REPORT, page(path, found), paper)
            shown = tables(found)
    if not quiet:
        show(*shown)
        print(path / REPORT)
    if failed:
        raise RunError(f"{failed} of the runs could not get a page")


def _write_missing(path: Path, runs: list[Run]) -> int:
    """Write the missing pages of finished runs; return the number of failures."""
    missing = [run for run in runs if run.state == "finished" and not run.page]
    failed = 0
    for k, run in enumerate(missing, 1):
        place = path / run.path
        outcome: object = place / REPORT
        try:
            write_page(*finished_run(place), place)
        except UserError as error:
            failed += 1
            outcome = error.typed
        print(f"page {k}/{len(missing)}  {outcome}", file=sys.stderr)
    return failed


def _write_tables(out: Path, findings: Findings, parquet: bool) -> None:
    columns = _run_columns(findings)
    content = _parquet(columns) if parquet else b""  # may fail, so before anything is written
    rows: dict[str, Rows] = {
        RUNS: [list(columns), *zip(*columns.values(), strict=True)],
        GROUPS: _group_rows(findings.groups),
        COMPARISONS: _comparison_rows(findings.comparisons),
    }
    if findings.figures:
        rows[PUBLISHED] = [Reproduced._fields, *findings.figures]
    if findings.winners:
        rows[STRUCTURES] = _winner_rows(findings.winners)
    for name, table in rows.items():
        write_whole(out / name, csv_text(table).encode())
    if parquet:
        write_whole(out / PARQUET, content)


def _run_columns(findings: Findings) -> dict[str, Column]:
    """Return the columns of ``runs.csv``: name -> a value for each run; None: it has no value."""
    runs, number = findings.runs, findings.number_of()
    judged = any(run.verdict for run in runs)
    margins = [key for key in MARGINS if any(key in run.margins for run in runs)]
    parts: list[tuple[Json, ...]] = []  # of a row; columns with the same names belong together
    for run in runs:
        numbers = {"group": number.get(run.path), "state": run.state, "generations": len(run.best)}
        use = {"verdict": run.verdict or None, "share": run.share}
        use |= {key: run.margins.get(key) for key in margins} | {"answer": run.answer or None}
        highest = {f"{key}_highest": ends["highest"] for key, ends in run.ranges.items()}
        last = {JUDGED_BY: run.judged_by or None, "reason": run.reason or None}
        first = {"run": run.path, "called": run.title, **numbers}
        parts.append((first, run.settings, use if judged else {}, run.score, highest, last))
    columns: dict[str, Column] = {}
    for part in zip(*parts, strict=True):
        for key in dict.fromkeys(key for row in part for key in row):
            values = [row.get(key) for row in part]
            numeric = all(value is None or type(value) in (int, float) for value in values)
            texts = (None if value is None else text(value) for value in values)
            columns[key] = values if numeric else [*texts]
    return columns


def _group_rows(groups: Sequence[Group]) -> Rows:
    medians = [group.metrics() for group in groups]
    metrics = list(dict.fromkeys(key for item in medians for key in item))
    keys = list(groups[0].settings) if groups else []
    head = ["group", "task", "measure", *keys, "runs", "finished"]
    yield [*head, *(f"{key}_{part}" for key in metrics for part in QUARTILES)]
    for x, item in zip(groups, medians, strict=True):
        which = [x.number, x.task, x.measure, *x.settings.values(), len(x.runs), len(x.scores)]
        yield [*which, *(value for key in metrics for value in item.get(key, (None,) * 3))]


def _winner_rows(winners: Iterable[Winner]) -> Rows:
    counted = ["runs", "searches", "share", "share_low", "share_high"]
    yield ["group", "task", "measure", "structure", *counted, "best", "median", "best_run"]
    for x in winners:
        which = [x.group.number, x.group.task, x.group.measure, x.structure]
        shares = [len(x.runs), x.searches, x.share, *x.interval]
        yield [*which, *shares, x.best, x.median, x.runs[0].path]


def _comparison_rows(comparisons: Sequence[Comparison]) -> Rows:
    which = ["task", "measure", "group", "other_group", "runs", "other_runs"]
    yield [*which, "a12", "p", "p_holm", "p_exact"]
    for x in comparisons:
        first, second, *tested = x
        yield [first.task, first.measure, first.number, second.number, *x.sizes, *tested]


def _parquet(columns: dict[str, Column]) -> bytes:
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        raise UserError("--parquet: needs pyarrow; pip install 'hfc-design[parquet]'") from None
    buffer = io.BytesIO()
    parquet.write_table(pyarrow.table(columns), buffer)
    return buffer.getvalue()
