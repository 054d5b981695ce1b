"""What functions return, drawn; and several over one another."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from hfc_design.batch.findings import Findings, of_findings
from hfc_design.calls.showing import column
from hfc_design.core.arguments import path_of, wanted
from hfc_design.core.records import UserError
from hfc_design.identify.page import replayed
from hfc_design.identify.result import Identified
from hfc_design.pictures.column import in_column
from hfc_design.pictures.files import save
from hfc_design.report import batch_plots, overlaid, plots, searches
from hfc_design.report.comparison.plots import machines
from hfc_design.report.paper import INCH
from hfc_design.runs.run import Result
from hfc_design.simulation.comparison import Comparison
from hfc_design.simulation.evaluating import EVALUATED, Evaluation
from hfc_design.simulation.in_use import Usable
from hfc_design.simulation.monte_carlo import Robustness
from hfc_design.stability.report import LoopMargins, StableGains

#: What ``plot`` draws beside an evaluation.
OTHERS = (Result, Robustness, Usable, Comparison, Identified, StableGains, LoopMargins, Findings)


def plot(
    found: Any, path: str | Path | None = None, title: str = "", width: str | None = None
) -> Figure:
    """Draw what was found: a figure, which a notebook shows by itself.

    Of an evaluation the motion, the first where there are several (draw ``found.motions["fast"]``
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
    if isinstance(found, Mapping):
        figure = _overlaid(found, title)
    else:
        wanted(found, (Evaluation, *OTHERS), f"{EVALUATED}, and nothing else that has a plot")
        figure = _drawn(found, title)
    if narrow is not None:
        in_column(figure, narrow)
    if place is not None:
        save(figure, place)
    return figure


def _drawn(found: Any, title: str) -> Figure:
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
    kind = type(found)
    if kind is Evaluation and found.motions and not title:
        title = f"{next(iter(found.motions))}, the first of {len(found.motions)} motions"
    if kind in titled:
        return titled[kind](found, title)
    if kind in others:
        return others[kind](found)
    if kind is not Result:
        figure: Figure = found.figure()
        return figure
    if found.search is None:
        raise UserError("nothing was searched; plot its .evaluation")
    return searches.history(found.search.history, title)


def _overlaid(found: Mapping[str, Any], title: str) -> Figure:
    """Several of one kind over one another."""
    kinds = {type(one) for one in found.values()}
    if kinds == {Evaluation}:
        motions = {
            (len(one.time), one.time[-1], tuple(axis.name for axis in one.axes))
            for one in found.values()
        }
        if several := next((one.motions for one in found.values() if one.motions), None):
            raise UserError(
                f"evaluations over one another have to be of one motion, these are of "
                f"{', '.join(several)}; take one of each, as .motions[{next(iter(several))!r}]"
            )
        if len(motions) > 1:
            raise UserError("evaluations over one another have to be of the same motion")
        return overlaid.motions(found, title)
    if kinds == {Findings}:
        return of_findings(found)
    if kinds == {Result}:
        for name, one in found.items():
            if one.search is None:
                raise UserError(f"{name}: nothing was searched; plot its .evaluation")
        bests = [[one.search.history.best] for one in found.values()]
        return searches.convergence([*found], bests, range(len(bests)))
    raise UserError("what lies over one another has to be all evaluations, results or findings")
