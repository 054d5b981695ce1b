"""Pages, what of them a paper wants, and which rules fire."""

import shlex
from collections.abc import Mapping
from os import PathLike
from os.path import isdir
from pathlib import Path
from typing import Any

from hfc_design.core.arguments import path_of, wanted
from hfc_design.core.checkpoint import write_whole
from hfc_design.core.records import UserError, harmless
from hfc_design.files.design import AnyDesign
from hfc_design.files.named_scenario import AnyScenario, load_scenario
from hfc_design.files.pairing import load_design, own_scenario
from hfc_design.report import REPORT
from hfc_design.report.comparison.page import page
from hfc_design.report.page import design_page
from hfc_design.report.paper import COLUMN, KINDS, Paper, millimetres
from hfc_design.runtime.explain import explained
from hfc_design.simulation.comparison import Comparison


def explain(
    found: AnyDesign, *samples: str | Mapping[str, float], axis: str = ""
) -> dict[str, Any]:
    """Which rules fire at a sample, how strongly, and what the command is made of.

    What ``hfc explain --json`` prints. A sample is {signal: reading} in the units of the plant, or
    a text as in "error=1e-4,error_change=0". With one the readings that the controller remembers
    are given too ("previous_error" or so); with several it steps through them from rest, and the
    last is explained. In "units" each rule that fires has its "strength" and its "share" (of 1);
    "command" is in "command_unit".

    Raises:
        UserError: the design has no rules, or signals are missing, unknown or no numbers.
    """
    if not samples:
        raise UserError("a sample is missing: signals and readings, as in {'error': 1e-4}")
    for one in samples:
        wanted(one, (str, Mapping), "sample: a text, or a mapping of signals to readings")
    texts = [
        one if isinstance(one, str) else ",".join(f"{name}={x}" for name, x in one.items())
        for one in samples
    ]
    return explained(load_design(found), texts, axis)


def comparison_page(
    comparison: Comparison,
    path: str | Path,
    *,
    figures: str | None = None,
    width: str | None = None,
    latex: bool = False,
) -> Path:
    """Write the page of a comparison, one file with everything inside it.

    Args:
        comparison: what ``compare`` returned.
        path: of the page.
        figures: "pdf", "svg" or "pgf": every figure of the page as a file, in NAME-figures beside.
        width: of these, as in "88mm"; 3.5in if left out.
        latex: every table of the page in LaTeX, in NAME-latex beside.

    Raises:
        UserError: it is no comparison, or there is no such kind of figure or width.
        RunError: a file cannot be written.
    """
    wanted(comparison, Comparison, "comparison; compare(designs) makes one")
    place = path_of(path)
    paper = for_a_paper(place.parent, f"{place.stem}-", figures, width, latex)
    found = page(comparison)
    write_whole(place, found.html)
    if paper:
        paper.write(found)
    return place


def report(
    of: AnyDesign,
    path: str | Path | None = None,
    each: bool = False,
    scenario: AnyScenario | None = None,
    *,
    figures: str | None = None,
    width: str | None = None,
    latex: bool = False,
) -> Path:
    """Write the page of a run folder, of all runs below a folder, or of a lone design.

    What ``hfc report`` does. The page of a folder lies in it, as report.html; of many runs
    runs.csv, groups.csv and comparisons.csv beside it.

    Args:
        of: a folder, a design file or a built-in design, or a design.
        path: of the page of a lone design; NAME.html if left out.
        each: also write the page of every run below the folder that lacks one.
        scenario: of a lone design; the one that it was made for if left out.
        figures: "pdf", "svg" or "pgf": every figure of the page as a file, in the folder figures
            of the run or batch, of a lone design in NAME-figures beside the page.
        width: of these, as in "88mm"; 3.5in if left out.
        latex: every table of the page in LaTeX, in the folder latex, or NAME-latex.

    Returns:
        The page.

    Raises:
        UserError: there is no such folder or design, or no run in it; or ``path`` is named for
            the page of a folder; or there is no such kind of figure or width.
        RunError: a file cannot be written.
    """
    if isinstance(of, str | PathLike) and isdir(of):
        from hfc_design.batch.report import report

        if path is not None:
            told = f"{path}: is for a lone design; leave path out, the page of a folder lies in it"
            raise UserError(f"{told}, as {Path(of) / REPORT}")
        if scenario is not None:
            raise UserError("scenario: is for a lone design; a run has its own")
        paper = for_a_paper(Path(of), "", figures, width, latex)
        report(Path(of), each, tell=lambda page, found: None, paper=paper)
        return Path(of) / REPORT
    if each:
        raise UserError("each: is for a folder of runs, and this is a design")
    design = load_design(of)
    name = design.name if of is design else str(of)
    place = Path(f"{design.name}.html") if path is None else path_of(path)
    where = own_scenario(design, name) if scenario is None else load_scenario(scenario)
    paper = for_a_paper(place.parent, f"{place.stem}-", figures, width, latex)
    found = design_page(design, where, harmless(shlex.join(["hfc", "score", name])))
    write_whole(place, found.html)
    if paper:
        paper.write(found)
    return place


def for_a_paper(
    folder: Path, stem: str, figures: str | None, width: str | None, latex: bool
) -> Paper | None:
    """In folders that begin with a ``stem``; None where nothing is wanted.

    Raises:
        UserError: there is no such kind of figure or width, or a width without figures.
    """
    if figures is not None and figures not in KINDS:
        raise UserError(f"figures = {figures!r}: has to be one of {', '.join(KINDS)}")
    if width is not None and figures is None:
        raise UserError("width: is that of figures, as in figures='pdf'")
    if figures is None and not latex:
        return None
    drawn = folder / f"{stem}figures" if figures else None
    size = COLUMN if width is None else column(width)
    return Paper(figures or "", size, drawn, folder / f"{stem}latex" if latex else None)


def column(width: str) -> float:
    """A width in millimetres; UserError: it is none."""
    try:
        return millimetres(width)
    except (ValueError, TypeError):
        told = "a text with a number and a unit (mm, cm, in, pt), 40 to 400 mm in all"
        raise UserError(f"width = {width!r}: has to be {told}") from None
