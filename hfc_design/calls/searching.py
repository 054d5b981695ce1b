"""Controllers for a scenario: searched, picked from a front, or with given gains."""

from collections.abc import Callable, Mapping
from contextlib import nullcontext
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
    """Search for a controller; return the design, its evaluation on the scenario, and the search.

    With ``folder``, a run folder with a report is written there, as by ``hfc design``. If the
    folder contains a stopped run of the same scenario, that run is continued; with ``anyway`` even
    if it was started by other versions of packages or of own parts. ``on_generation`` is called
    with the state of the search after every generation.

    Raises:
        UserError: the folder contains a run of another scenario.
        RunError: every candidate diverged; the folder cannot be written or is in use; or its
            checkpoint is damaged or of other versions.
    """
    from hfc_design.report.page import write_page  # imports Matplotlib

    scenario = load_scenario(scenario)
    if folder is None:
        with TemporaryDirectory() as name:
            run = runs.new_run(scenario, Path(name))
            return runs.run(run, Path(name), on_generation)
    check_memory(scenario)
    place = path_of(folder)
    with exclusive(place):
        old = runs.opened_run(place) if (place / runs.CONFIG).exists() else None
        if old:
            # The folder holds copies of the files that a scenario names.
            one, other = (renamed(x, lambda key, file: Path(key)) for x in (old, scenario))
            if one != other:
                raise UserError(f"{place}: contains a run of another scenario; name another folder")
        with nullcontext() if old else runs.begun(place):
            run = old or runs.new_run(scenario, place)
            result = runs.run(run, place, on_generation, anyway)
        write_page(run, result, place)
        return result


def pick(
    folder: str | Path, point: int | None = None, nearest: Mapping[str, float | str] | None = None
) -> Design:
    """Return the design of a point of the front in a run folder.

    The point is the one with the number ``point`` in ``front.csv``, or the one ``nearest`` to given
    costs (objective -> number or text with a unit); default: the knee of the front. For the folder
    of a batch, or of several runs, the result is the best usable design.

    Raises:
        UserError: there is no finished run, no front, no such point, or no usable design.
        RunError: a file of the run is damaged.
    """
    from hfc_design.batch.results import best_usable, is_run  # imports Matplotlib

    if point is not None:
        check_whole("point", point, 1)
    place = path_of(folder)
    if place.is_dir() and not is_run(place) and point is None and nearest is None:
        return load_design(place / best_usable(place).path)
    scenario, result = runs.finished_run(place)
    front = runs.front_needed(place, result)
    return runs.picked(scenario, result, chosen(front, scenario, point, nearest))[0]


def with_gains(scenario: AnyScenario, kind: str, gains: Mapping[str, Any]) -> Design:
    """Return a design with given gains, of kind pd, pid, pid+ff or of a user's own control law.

    Raises:
        UserError: the kind does not exist or has other gains, or a gain is given for an unknown
            signal.
    """
    of_gains = KINDS.get(kind).of_gains
    if of_gains is None:
        raise UserError(f"kind must be pd, pid or pid+ff (got {kind})")
    check_type(gains, Mapping, "a mapping of names to gains")
    where = load_scenario(scenario)
    design = design_with({"kind": kind, **of_gains(dict(gains))}, where)
    check_laws(design, where.plant.machine)
    return design
