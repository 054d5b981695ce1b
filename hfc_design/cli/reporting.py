"""The command that writes pages: of a run, of several runs, of a single design."""

from functools import partial
from os.path import exists, isdir
from pathlib import Path
from typing import TYPE_CHECKING

import click

from hfc_design.cli import options as common
from hfc_design.cli.binding import PATH, Texts, argument, command, option
from hfc_design.cli.functions import function
from hfc_design.cli.names import SCENARIO
from hfc_design.cli.usage import refusal

if TYPE_CHECKING:
    from hfc_design.report.paper import Paper

#: Options that select the parts of a page for a paper.
PAPERS = function(
    *("report.paper.for_a_paper", "folder", "stem"),
    figures=option(None, kind=click.Choice(("pdf", "svg", "pgf"))),
)


def paper_of(papers: "partial[Paper | None]", folder: Path, stem: str = "") -> "Paper | None":
    """Return the parts of a page for a paper; UserError: their folders exist without --force."""
    if paper := papers(folder, stem):
        for option, path in (("--figures", paper.figures), ("--latex", paper.tables)):
            if path is not None:
                common.free(path, option, folder=True)
    return paper


@command("Write the page of a run, of many runs, or of a single DESIGN.", last=common.KNOWING)
def report(
    place: Path = argument(PATH, metavar="FOLDER|DESIGN"),
    others: Texts = common.CHANGING,
    scenario: str | None = option(common.SCENARIO_HELP, kind=SCENARIO),
    changes: Texts = common.SETTING,
    each: bool = option("Also write the page of every run that lacks one."),
    parquet: bool = option("Also write runs.parquet (needs pyarrow)."),
    out: Path | None = common.output("Page of a single DESIGN [default: NAME.html]."),
    papers: "partial[Paper | None]" = PAPERS,
) -> None:
    """Write report.html of a run FOLDER, or of all runs below a FOLDER.

    Of many runs: medians and quartiles over the seeds, convergence, significance, failures; the
    same numbers as runs.csv, groups.csv and comparisons.csv; of hierarchies the structures that the
    searches ended with, also as structures.csv.

    Of a DESIGN, a built-in name or a design file: NAME.html, the page of a run without the search,
    on the scenario that the design was made for. With --scenario, --set or --change the same for
    the design of a run.

    --figures and --latex write the folders figures and latex into FOLDER, for a DESIGN NAME-figures
    and NAME-latex beside the page.
    """
    from hfc_design.batch.report import report as report_folder
    from hfc_design.core.console import busy
    from hfc_design.files.design import builtin_designs
    from hfc_design.report.page import design_page
    from hfc_design.report.paper import write_with_parts

    if not (exists(place) or str(place) in builtin_designs()):
        raise refusal(f"{place}: must be a folder, a design file or a built-in design")
    if isdir(place) and not (scenario or changes or others):
        if out is not None:
            raise refusal(
                f"--out {out}: applies to a single design; the page of a folder is written "
                "into the folder"
            )
        report_folder(place, each, parquet, paper_of(papers, place))
        return
    if each or parquet:
        raise refusal(f"{place}: is a design; --each and --parquet apply to folders of runs")
    path = out or common.free(Path(f"{place.stem}.html"))
    paper = paper_of(papers, path.parent, f"{path.stem}-")
    chosen = (scenario,) if scenario else ()
    design, (where,), _ = common.loops_of(str(place), others, chosen, changes)
    differs = {"--change": others, "--scenario": chosen, "--set": changes}
    with busy("the page, on unseen machines"):
        line = common.again(["hfc", "score", str(place)], differs, [design])
        page = design_page(design, where, line)
    write_with_parts(path, page, paper)
    click.echo(path)
