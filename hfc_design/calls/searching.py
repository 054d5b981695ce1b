"""A controller for a scenario: searched, picked from a front, or by hand."""

from collections.abc import Callable, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from hfc_design.controllers.kinds import KINDS
from hfc_design.core.arguments import check_type, check_whole, path_of
from hfc_design.core.lock import exclusive
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.files.loop_setup import check_laws, load_design
from hfc_design.files.named_scenario import AnyScenario, load_scenario, renamed
from hfc_design.runs import run as runs
from hfc_design.runs.front import chosen
from hfc_design.runs.individuals import design_with
from hfc_design.runs.problem import check_memory
from hfc_design.runs.run import Result
from hfc_design.search.loop import Search


def design(
    scenario: AnyScenario,
    folder: str | Path | None = None,
    on_generation: Callable[[Search], None] = lambda search: None,
    anyway: bool = False,
) -> Result:
    """Search a controller; returns its design file, its evaluation on the scenario, and the search.

    With ``folder`` it leaves a run folder and a report there, as ``hfc design`` does. If the folder
    holds a stopped run of the same scenario, it continues that run; with ``anyway`` even if other
    versions of packages or of own parts began it.

    Raises:
        UserError: the folder holds a run of another scenario.
        RunError: everything diverged; the folder cannot be written or is in use, or its checkpoint
            is damaged or of other versions.
    """
    from hfc_design.report.page import write_page  # which draws

    scenario = load_scenario(scenario)
    if folder is None:
        with TemporaryDirectory() as name:
            run = runs.new_run(scenario, Path(name))
            return runs.run(run, Path(name), on_generation)
    check_memory(scenario)
    place = path_of(folder)
    with exclusive(place):
        if (place / runs.CONFIG).exists():
            run = runs.opened_run(place)
            # The folder holds copies of the files that a scenario names.
            one, other = (renamed(x, lambda key, file: Path(key)) for x in (run, scenario))
            if one != other:
                raise UserError(f"{place}: contains a run of another scenario; name another folder")
        else:
            run = runs.new_run(scenario, place)
        result = runs.run(run, place, on_generation, anyway)
        write_page(run, result, place)
        return result


def pick(
    folder: str | Path, point: int | None = None, nearest: Mapping[str, float | str] | None = None
) -> Design:
    """The design of a point of the front that the run in a folder has found.

    That of a number in its ``front.csv``, the one nearest to costs (objective -> a number or a
    text with a unit), or else the knee. Of the folder of a batch, or of many runs, it is the best
    design that can be used.

    Raises:
        UserError: there is no finished run, no front, no such point, or no design that can be used.
        RunError: a file of the run is damaged.
    """
    from hfc_design.batch.results import best_usable, is_run  # with all that draws

    if point is not None:
        check_whole("--point", point, 1)
    place = path_of(folder)
    if place.is_dir() and not is_run(place) and point is None and nearest is None:
        return load_design(place / best_usable(place).path)
    scenario, result = runs.finished_run(place)
    front = runs.front_needed(place, result)
    return runs.picked(scenario, result, chosen(front, scenario, point, nearest))[0]


def with_gains(scenario: AnyScenario, kind: str, gains: Mapping[str, Any]) -> Design:
    """A design by hand: a controller of kind pd, pid, pid+ff or an own law with these gains.

    Raises:
        UserError: no such kind, it has other gains, or a gain is of what is no signal.
    """
    of_gains = KINDS.get(kind).of_gains
    if of_gains is None:
        raise UserError(f"kind must be pd, pid or pid+ff (got {kind})")
    check_type(gains, Mapping, "a table of gains and their values")
    where = load_scenario(scenario)
    design = design_with({"kind": kind, **of_gains(dict(gains))}, where)
    check_laws(design, where.plant.machine)
    return design
