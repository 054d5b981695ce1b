"""Options of the commands that write a page: its figures and tables for a paper."""

from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from hfc_design.cli.options import Command, free

if TYPE_CHECKING:
    from hfc_design.report.paper import Paper

#: Those of ``report.paper``, which takes long to import.
KINDS = "pdf", "svg", "pgf"
#: Of a place, where its folders lie and what their names begin with: what is wanted there.
Papers = Callable[[Path, str], "Paper | None"]


def for_a_paper(command: Command) -> Command:
    """A command that has ``force``: it gets ``papers``, which tells what is wanted of a page."""

    @click.option(
        "--figures",
        type=click.Choice(KINDS),
        help="Every figure of the page as a file too, for the column of a paper.",
    )
    @click.option(
        "--width",
        callback=millimetres_of,
        metavar="WIDTH",
        help="Of these figures, as in 88mm, 3.5in, 252pt [default: 3.5in].",
    )
    @click.option("--latex", is_flag=True, help="Every table of the page in LaTeX too.")
    @wraps(command)
    def wrapped(figures: str | None, width: float | None, latex: bool, **given: Any) -> None:
        from hfc_design.core.records import UserError

        if width is not None and figures is None:
            raise UserError(f"--width: is that of figures; add --figures {'|'.join(KINDS)}")

        def papers(folder: Path, stem: str = "") -> "Paper | None":
            if figures is None and not latex:
                return None
            from hfc_design.report.paper import COLUMN, Paper

            drawn = free(folder / f"{stem}figures", "--figures", folder=True) if figures else None
            tables = free(folder / f"{stem}latex", "--latex", folder=True) if latex else None
            return Paper(figures or "", COLUMN if width is None else width, drawn, tables)

        command(papers=papers, **given)

    return wrapped


def millimetres_of(_: click.Context, option: click.Parameter, told: str | None) -> float | None:
    """A width in millimetres."""
    if told is None:
        return None
    from hfc_design.report.paper import millimetres

    try:
        return millimetres(told)
    except ValueError as error:
        raise click.BadParameter(str(error)) from None
