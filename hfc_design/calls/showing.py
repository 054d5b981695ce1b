"""Display of results: figures, pages with figures and tables for a paper, rules that fire."""

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
from hfc_design.core.records import UserError, harmless
from hfc_design.files.design import AnyDesign
from hfc_design.files.loop_setup import load_design, own_scenario
from hfc_design.files.named_scenario import AnyScenario, load_scenario
from hfc_design.identify.identified import Identified
from hfc_design.identify.page import replayed
from hfc_design.plotting.column import in_column
from hfc_design.plotting.files import save
from hfc_design.report import REPORT, batch_plots, overlaid, plots, searches
from hfc_design.report.comparison.page import page
from hfc_design.report.comparison.plots import machines
from hfc_design.report.page import design_page
from hfc_design.report.paper import INCH, column, for_a_paper, write_with_parts
from hfc_design.runs.run import Result
from hfc_design.runtime.explain import explained
from hfc_design.simulation.acceptance import Usable
from hfc_design.simulation.comparison import Comparison
from hfc_design.simulation.evaluating import EVALUATED, Evaluation
from hfc_design.simulation.monte_carlo import Robustness
from hfc_design.stability.report import LoopMargins, StableGains

#: Results other than an evaluation that ``plot`` draws.
OTHERS = (Result, Robustness, Usable, Comparison, Identified, StableGains, LoopMargins, Findings)


def plot(
    result: Any, path: str | Path | None = None, title: str = "", width: str | None = None
) -> Figure:
    """Draw a result as a figure, which a notebook displays by itself.

    What is drawn depends on the result:

    - an evaluation: the motion, or the first of several motions (draw ``result.motions["fast"]``
      for another one);
    - a result of ``design``: the progress of the search;
    - ``findings``: the progress of the searches of each group;
    - ``robustness``, ``usable`` and ``compare``: the metrics on all machines;
    - ``identify``: the replay beside the log;
    - ``stability``: the range of stable gains or the open loop;
    - a mapping of names to evaluations: their motions in one figure;
    - a mapping of names to results or to findings: their searches in one figure.

    Only evaluations, results, robustness and usable use the ``title``. Axes have the units of the
    plant.

    Args:
        result: return value of one of these functions, or a mapping of names to several of a kind.
        path: png, svg or pdf file to write; default: no file is written.
        title: title above the figure.
        width: width of the column of a paper for which the figure is laid out, as in "88mm".

    Raises:
        UserError: the result is none of these, the kind of file or the width is invalid, or the
            results of a mapping cannot share a figure.
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
    """Draw several results of one kind in one figure."""
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
        bests = {name: [one.search.history.best] for name, one in results.items()}
        return searches.convergence(bests)
    raise UserError("a figure of several must have only evaluations, only results or only findings")


def explain(
    design: AnyDesign, *samples: str | Mapping[str, float], axis: str = ""
) -> dict[str, Any]:
    """Return the rules that fire at a sample, their strengths, and how they make up the command.

    The dictionary is the one that ``hfc explain --json`` prints. A sample is {signal: reading} in
    the units of the plant, or a text as in "error=1e-4,error_change=0". A single sample also gives
    the readings that the controller remembers (such as "previous_error"); with several samples the
    controller steps through them from rest, and the last one is explained. In "units", each rule
    that fires has its "strength" and its "share" (of 1); the unit of "command" is "command_unit".

    Raises:
        UserError: the design has no rules, or signals are missing, unknown or not numbers.
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
    """Write the page of a comparison as a single self-contained file and return its path.

    Args:
        comparison: return value of ``compare``.
        path: path of the page.
        figures: "pdf", "svg" or "pgf": write every figure of the page as a file of this kind, to
            the folder NAME-figures beside the page.
        width: width of these figures, as in "88mm"; default: 3.5in.
        latex: write every table of the page in LaTeX, to the folder NAME-latex beside the page.

    Raises:
        UserError: ``comparison`` is not a comparison, or the kind of figure or width is invalid.
        RunError: a file cannot be written.
    """
    check_type(comparison, Comparison, "a comparison, as compare(designs) returns it")
    place = path_of(path)
    paper = for_a_paper(place.parent, f"{place.stem}-", figures, width, latex)
    html = page(comparison)
    write_with_parts(place, html, paper)
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
    """Write the page of a run folder, of all runs below a folder, or of a single design.

    The counterpart of ``hfc report``. The page of a folder is written into it, as report.html; for
    a folder of several runs, runs.csv, groups.csv and comparisons.csv are written beside it.

    Args:
        of: folder, design file, name of a built-in design, or design.
        path: path of the page of a single design; default: NAME.html.
        each: also write the missing pages of the runs below the folder.
        scenario: scenario of a single design; default: the one that the design was made for.
        figures: "pdf", "svg" or "pgf": write every figure as a file of this kind, to the folder
            figures of the run or batch, for a single design to NAME-figures beside the page.
        width: width of these figures, as in "88mm"; default: 3.5in.
        latex: write every table in LaTeX, to the folder latex, for a design to NAME-latex.

    Returns:
        The path of the page.

    Raises:
        UserError: the folder or design does not exist, or the folder contains no run; ``path`` or
            ``scenario`` is given for a folder, or ``each`` for a design; or the kind of figure or
            the width is invalid.
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
        batch_report.report(Path(of), each, paper=paper, quiet=True)
        return Path(of) / REPORT
    if each:
        raise UserError("each: applies to a folder of runs (got a design)")
    design = load_design(of)
    name = design.name if of is design else str(of)
    place = Path(f"{design.name}.html") if path is None else path_of(path)
    where = own_scenario(design, name) if scenario is None else load_scenario(scenario)
    paper = for_a_paper(place.parent, f"{place.stem}-", figures, width, latex)
    html = design_page(design, where, harmless(shlex.join(["hfc", "score", name])))
    write_with_parts(place, html, paper)
    return place
