"""Pictures, pages, and which rules fire."""

import shlex
from collections.abc import Callable, Mapping
from os import PathLike
from os.path import isdir
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hfc_design.core.arguments import path_of, wanted
from hfc_design.core.checkpoint import write_whole
from hfc_design.core.records import UserError, harmless
from hfc_design.files.design import AnyDesign
from hfc_design.files.named_scenario import AnyScenario, load_scenario
from hfc_design.files.pairing import load_design, own_scenario
from hfc_design.identify.result import Identified
from hfc_design.runs.run import Result
from hfc_design.runtime.explain import explained
from hfc_design.simulation.comparison import Comparison
from hfc_design.simulation.evaluation import EVALUATED, Evaluation
from hfc_design.simulation.in_use import Usable
from hfc_design.simulation.monte_carlo import Robustness
from hfc_design.stability.loop_report import LoopMargins
from hfc_design.stability.report import StableGains

if TYPE_CHECKING:
    from matplotlib.figure import Figure  # takes longer than all the rest


#: What ``plot`` draws beside an evaluation.
OTHERS = (Result, Robustness, Usable, Comparison, Identified, StableGains, LoopMargins)


def plot(found: Any, path: str | Path | None = None, title: str = "") -> "Figure":
    """Draw what was found: a figure, which a notebook shows by itself.

    Of an evaluation the motion, of a result of ``design`` how the search went, of ``robustness``,
    ``usable`` and ``compare`` the metrics on all machines, of ``identify`` the replay beside the
    log, of ``stability`` the range or the open loop. The first four have a ``title``. Axes have the
    units of the plant.

    Args:
        found: what one of these functions returned.
        path: png, svg or pdf file that it is written to; none is if left out.
        title: stands above.

    Raises:
        UserError: it is none of these, or there is no such kind of file.
        RunError: ``path`` cannot be written.
    """
    from hfc_design.pictures.files import save

    place = None if path is None else path_of(path)
    wanted(found, (Evaluation, *OTHERS), f"{EVALUATED}, and nothing else that has a plot")
    figure = _drawn(found, title)
    if place is not None:
        save(figure, place)
    return figure


def _drawn(found: Any, title: str) -> "Figure":
    from hfc_design.identify.plots import replayed
    from hfc_design.report import batch_plots, plots, searches, usable_plots
    from hfc_design.report.comparison.plots import machines

    titled: dict[type, Callable[[Any, str], Figure]] = {
        Evaluation: plots.motion,
        Usable: usable_plots.distributions,
        Robustness: batch_plots.distributions,
    }
    others: dict[type, Callable[[Any], Figure]] = {Comparison: machines, Identified: replayed}
    kind = type(found)
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


def picture(found: AnyDesign, what: str, unit: str | None = None, axis: str = "") -> "Figure":
    """What a design is as a figure, as ``hfc plot`` has it.

    ``what`` is "surface", "surface-3d", "terms", "tables" or "tree", as far as the kind has it;
    ``unit`` is the fuzzy unit of a hierarchy, as in "unit-1", the root if none is named; ``axis``
    that of a controller whose axes differ. Axes have the units of the plant.

    Raises:
        UserError: the kind has no such picture, or there is no such unit or axis.
    """
    from hfc_design.report.designs import picture

    return picture(load_design(found), what, unit, axis)


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


def comparison_page(comparison: Comparison, path: str | Path) -> Path:
    """Write the page of a comparison, one file with everything inside it.

    Raises:
        UserError: it is no comparison.
        RunError: ``path`` cannot be written.
    """
    from hfc_design.report.comparison.page import page

    wanted(comparison, Comparison, "comparison; compare(designs) makes one")
    place = path_of(path)
    write_whole(place, page(comparison).html)
    return place


def report(
    of: AnyDesign,
    path: str | Path | None = None,
    each: bool = False,
    scenario: AnyScenario | None = None,
) -> Path:
    """Write the page of a run folder, of all runs below a folder, or of a lone design.

    What ``hfc report`` does. The page of a folder lies in it, as report.html; of many runs
    runs.csv, groups.csv and comparisons.csv beside it.

    Args:
        of: a folder, a design file or a built-in design, or a design.
        path: of the page of a lone design; NAME.html if left out.
        each: also write the page of every run below the folder that lacks one.
        scenario: of a lone design; the one that it was made for if left out.

    Returns:
        The page.

    Raises:
        UserError: there is no such folder or design, or no run in it; or ``path`` is named for
            the page of a folder.
        RunError: the page cannot be written.
    """
    if isinstance(of, str | PathLike) and isdir(of):
        from hfc_design.batch.report import report
        from hfc_design.report import REPORT

        if path is not None:
            raise UserError(f"{path}: is for a lone design; the page of a folder lies in it")
        if scenario is not None:
            raise UserError("scenario: is for a lone design; a run has its own")
        report(Path(of), each, tell=lambda page, winners: None)
        return Path(of) / REPORT
    from hfc_design.report.page import design_page

    if each:
        raise UserError("each: is for a folder of runs, and this is a design")
    design = load_design(of)
    name = design.name if of is design else str(of)
    place = Path(f"{design.name}.html") if path is None else path_of(path)
    where = own_scenario(design, name) if scenario is None else load_scenario(scenario)
    write_whole(
        place, design_page(design, where, harmless(shlex.join(["hfc", "score", name]))).html
    )
    return place
