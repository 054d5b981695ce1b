"""Commands on many runs: report, batch."""

from pathlib import Path

import click

from hfc_design.cli.options import PATH, Texts, knowing_plugins


@click.command()
@click.argument("folder", type=PATH)
@click.option("--each", is_flag=True, help="Also write the page of every run that lacks one.")
@click.option("--parquet", is_flag=True, help="Also write runs.parquet (needs pyarrow).")
@knowing_plugins
def report(folder: Path, each: bool, parquet: bool) -> None:
    """Write report.html of a run FOLDER, or of all runs below a FOLDER.

    Of many runs: medians and quartiles over the seeds, convergence, significance, what failed;
    the same numbers as runs.csv, groups.csv and comparisons.csv.
    """
    from hfc_design.batch.report import report

    report(folder, each, parquet)


BATCH_SET_HELP = "Change a value in every cell by its dotted key, as in search.generations=20."


@click.command()
@click.argument("file", required=False, type=PATH)
@click.option("--out", type=PATH, help="Folder [default: runs/NAME].")
@click.option("--set", "changes", multiple=True, metavar="KEY=VALUE", help=BATCH_SET_HELP)
@click.option("--dry-run", is_flag=True, help="Show the plan and how long it will take.")
@click.option("--status", type=PATH, help="What became of a batch's cells.")
@click.option("--workers", type=click.IntRange(min=1), help="Run so many cells at once, here.")
@click.option("--scheduler", metavar="ADDRESS", help="Run them on the workers of a Dask scheduler.")
@click.option("--shared", is_flag=True, help="Those workers see the folder: they write into it.")
@knowing_plugins
def batch(
    file: Path | None,
    status: Path | None,
    workers: int | None,
    scheduler: str | None,
    shared: bool,
    changes: Texts,
    dry_run: bool,
    out: Path | None,
) -> None:
    """Run every cell of a batch FILE (TOML): scenarios x seeds x any setting.

    What is finished is skipped, what broke off goes on where it stopped, what fails stops nothing.
    Without --workers or --scheduler one cell after the other, each on every core.
    """
    from hfc_design.batch import session
    from hfc_design.core.records import UserError

    if (file is None) == (status is None):
        raise UserError("give either a batch file or --status DIR")
    if workers is not None and scheduler is not None:
        raise UserError("give either --workers N or --scheduler ADDRESS")
    if shared and scheduler is None:
        raise UserError("--shared needs --scheduler ADDRESS")
    here = workers is None and scheduler is None
    where = None if here else session.Where(workers, scheduler, shared)
    if status is not None:
        session.show_status(status)
    elif file is not None:
        session.batch(file, out, dry_run, where, changes)
