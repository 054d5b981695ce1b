"""What was found, for the eye: figures, pages and what of them a paper wants, which rules fire."""

import shlex
from collections.abc import Callable, Mapping
from os import PathLike
from os.path import isdir
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from hfc_design.batch import report as batch_report
from hfc_design.batch.findings import Findings, of_findings
from hfc_design.core.arguments import check_type, path_of
from hfc_design.core.checkpoint import write_whole
from hfc_design.core.records import UserError, harmless
from hfc_design.files.design import AnyDesign
from hfc_design.files.loop_setup import load_design, own_scenario
from hfc_design.files.named_scenario import AnyScenario, load_scenario
from hfc_design.identify.page import replayed
from hfc_design.identify.result import Identified
from hfc_design.pictures.column import in_column
from hfc_design.pictures.files import save
from hfc_design.report import REPORT, batch_plots, overlaid, plots, searches
from hfc_design.report.comparison.page import page
from hfc_design.report.comparison.plots import machines
from hfc_design.report.page import design_page
from hfc_design.report.paper import COLUMN, INCH, KINDS, Paper, millimetres
from hfc_design.runs.run import Result
from hfc_design.runtime.explain import explained
from hfc_design.simulation.acceptance import Usable
from hfc_design.simulation.comparison import Comparison
from hfc_design.simulation.evaluating import EVALUATED, Evaluation
from hfc_design.simulation.monte_carlo import Robustness
from hfc_design.stability.report import LoopMargins, StableGains

#: What ``plot`` draws beside an evaluation.
OTHERS = (Result, Robustness, Usable, Comparison, Identified, StableGains, LoopMargins, Findings)


def plot(
    result: Any, path: str | Path | None = None, title: str = "", width: str | None = None
) -> Figure:
    """Draw what was found: a figure, which a notebook shows by itself.

    Of an evaluation the motion, the first where there are several (draw ``result.motions["fast"]``
    for another), of a result of ``design`` how the search went, of ``findings`` how
    the searches of each group went, of ``robustness``, ``usable`` and ``compare`` the metrics on
    all machines, of ``identify`` the replay beside the log, of ``stability`` the range or the open
    loop. Of a mapping of names to evaluations the motions over one another, to results or findings
    their searches. Evaluations, results, robustness and usable have a ``title``. Axes have the
    units of the plant.

    Args:
        found: what one of these functions returned, or several by the names that they are to have.
        path: png, svg or pdf file that it is written to; none is if left out.
        title: stands above.
        width: of the column of a paper that it is laid out for, as in "88mm".

    Raises:
        UserError: it is none of these, there is no such kind of file or width, or what lies over
            one another is not alike.
        RunError: ``path`` cannot be written.
    """
    place = None if path is None else path_of(path)
    narrow = None if width is None else column(width) / INCH
    if isinstance(result, Mapping):
        figure = _overlaid(result, title)
    else:
        check_type(result, (Evaluation, *OTHERS), EVALUATED)
        figure = _drawn(result, title)
    if narrow is not None:
        in_column(figure, narrow)
    if place is not None:
        save(figure, place)
    return figure


def _drawn(result: Any, title: str) -> Figure:
    titled: dict[type, Callable[[Any, str], Figure]] = {
        Evaluation: plots.motion,
        Usable: batch_plots.distributions,
        Robustness: batch_plots.distributions,
    }
    others: dict[type, Callable[[Any], Figure]] = {
        Comparison: machines,
        Identified: replayed,
        Findings: lambda one: of_findings({"": one}),
    }
    kind = type(result)
    if kind is Evaluation and result.motions and not title:
        title = f"{next(iter(result.motions))}, the first of {len(result.motions)} motions"
    if kind in titled:
        return titled[kind](result, title)
    if kind in others:
        return others[kind](result)
    if kind is not Result:
        figure: Figure = result.figure()
        return figure
    if result.search is None:
        raise UserError("this has no search to plot; plot its .evaluation")
    return searches.history(result.search.history, title)


def _overlaid(results: Mapping[str, Any], title: str) -> Figure:
    """Several of one kind over one another."""
    kinds = {type(one) for one in results.values()}
    if kinds == {Evaluation}:
        motions = {
            (len(one.time), one.time[-1], tuple(axis.name for axis in one.axes))
            for one in results.values()
        }
        if several := next((one.motions for one in results.values() if one.motions), None):
            raise UserError(
                "evaluations in one figure must be of one motion (got "
                f"{', '.join(several)}); take one of each, as "
                f".motions[{next(iter(several))!r}]"
            )
        if len(motions) > 1:
            raise UserError("evaluations in one figure must be of the same motion")
        return overlaid.motions(results, title)
    if kinds == {Findings}:
        return of_findings(results)
    if kinds == {Result}:
        for name, one in results.items():
            if one.search is None:
                raise UserError(f"{name}: this has no search to plot; plot its .evaluation")
        bests = [[one.search.history.best] for one in results.values()]
        return searches.convergence([*results], bests, range(len(bests)))
    raise UserError("a figure of several must have only evaluations, only results or only findings")


def explain(
    design: AnyDesign, *samples: str | Mapping[str, float], axis: str = ""
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
        raise UserError("samples must have at least one, as in {'error': 1e-4}")
    for one in samples:
        check_type(one, (str, Mapping), "a sample: a string, or a mapping of signals to readings")
    texts = [
        one if isinstance(one, str) else ",".join(f"{name}={x}" for name, x in one.items())
        for one in samples
    ]
    return explained(load_design(design), texts, axis)


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
    check_type(comparison, Comparison, "a comparison, as compare(designs) returns it")
    place = path_of(path)
    paper = for_a_paper(place.parent, f"{place.stem}-", figures, width, latex)
    html = page(comparison)
    write_whole(place, html.html)
    if paper:
        paper.write(html)
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
        if path is not None:
            line = (
                f"{path}: applies to a single design; leave path out, the page of a folder is "
                "written into the folder"
            )
            raise UserError(f"{line}, as {Path(of) / REPORT}")
        if scenario is not None:
            raise UserError("scenario: applies to a single design; a run has its own")
        paper = for_a_paper(Path(of), "", figures, width, latex)
        batch_report.report(Path(of), each, tell=lambda page, findings: None, paper=paper)
        return Path(of) / REPORT
    if each:
        raise UserError("each: applies to a folder of runs (got a design)")
    design = load_design(of)
    name = design.name if of is design else str(of)
    place = Path(f"{design.name}.html") if path is None else path_of(path)
    where = own_scenario(design, name) if scenario is None else load_scenario(scenario)
    paper = for_a_paper(place.parent, f"{place.stem}-", figures, width, latex)
    html = design_page(design, where, harmless(shlex.join(["hfc", "score", name])))
    write_whole(place, html.html)
    if paper:
        paper.write(html)
    return place


def for_a_paper(
    folder: Path, stem: str, figures: str | None, width: str | None, latex: bool
) -> Paper | None:
    """In folders that begin with a ``stem``; None where nothing is wanted.

    Raises:
        UserError: there is no such kind of figure or width, or a width without figures.
    """
    if figures is not None and figures not in KINDS:
        raise UserError(f"figures = {figures!r}: must be one of {', '.join(KINDS)}")
    if width is not None and figures is None:
        raise UserError("width: applies to figures, as in figures='pdf'")
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
        rule = "a string with a number and a unit (mm, cm, in, pt), 40 to 400 mm in total"
        raise UserError(f"width = {width!r}: must be {rule}") from None
