"""A controller for a scenario: searched, picked from a front, or by hand; many, by a batch."""

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from hfc_design.batch.findings import Findings
from hfc_design.batch.findings import findings as summed_up
from hfc_design.batch.plan import Cell, read_batch
from hfc_design.batch.report import report
from hfc_design.batch.results import best_usable, is_run, runs_below
from hfc_design.batch.runner import Outcome, Place, run_batch
from hfc_design.controllers.kinds import KINDS
from hfc_design.core.arguments import path_of, wanted, whole
from hfc_design.core.dotted import Changes
from hfc_design.core.lock import alone
from hfc_design.core.records import RunError, UserError
from hfc_design.files.design import Design
from hfc_design.files.named_scenario import AnyScenario, load_scenario, renamed
from hfc_design.files.pairing import check_laws, load_design
from hfc_design.report.page import write_page
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
    """Search a controller: its design file, what it does on the scenario, and the search.

    With ``folder`` it leaves a run folder and a report there, as ``hfc design`` does. Called
    again for a run of the same scenario that was stopped, it goes on; ``anyway`` even if other
    versions of packages or own parts began it.

    Raises:
        UserError: the folder holds a run of another scenario.
        RunError: everything diverged; the folder cannot be written or is in use, or its checkpoint
            is damaged or of other versions.
    """
    scenario = load_scenario(scenario)
    if folder is None:
        with TemporaryDirectory() as name:
            own = runs.new_run(scenario, Path(name))
            return runs.run(own, Path(name), on_generation)
    check_memory(scenario)
    place = path_of(folder)
    with alone(place):
        if (place / runs.CONFIG).exists():
            own = runs.opened_run(place)
            # The folder holds copies of the files that a scenario names.
            one, other = (renamed(x, lambda key, file: Path(key)) for x in (own, scenario))
            if one != other:
                raise UserError(f"{place}: holds a run of another scenario; name another folder")
        else:
            own = runs.new_run(scenario, place)
        result = runs.run(own, place, on_generation, anyway)
        write_page(own, result, place)
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
    if point is not None:
        whole("--point", point, 1)
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
        raise UserError(f"a controller of kind {kind} is no list of gains; pd, pid or pid+ff is")
    wanted(gains, Mapping, "table of gains and their values")
    where = load_scenario(scenario)
    found = design_with({"kind": kind, **of_gains(dict(gains))}, where)
    check_laws(found, where.plant.machine)
    return found


def batch(
    file: str | Path,
    folder: str | Path | None = None,
    changes: Changes = (),
    *,
    workers: int | None = None,
    anyway: bool = False,
    on_cell: Callable[[Cell, Outcome], None] = lambda cell, outcome: None,
) -> Findings:
    """Run every cell of a batch file that is not finished, and sum up what they gave.

    What ``hfc batch`` does: what broke off goes on where it stopped, what fails stops nothing;
    page and tables are written to the folder.

    Args:
        file: the batch, TOML.
        folder: of its runs; runs/NAME if left out.
        changes: of every cell, by dotted keys.
        workers: processes that run a cell each; without them one cell after the other, each on
            every core. Processes need a script whose work is under ``if __name__ == "__main__"``.
        anyway: go on with cells that other versions of packages or own parts began.
        on_cell: is called with every cell that is done and what became of it.

    Raises:
        UserError: the batch file is not one, or a cell needs more memory than there is.
        RunError: cells failed, after all others have run; ``findings`` tells of them too.
    """
    if workers is not None:
        whole("--workers", workers, 1)
    plan = read_batch(path_of(file), changes)
    out = plan.folder(None if folder is None else path_of(folder))
    places: AbstractContextManager[Place] = nullcontext(Place())
    if workers is not None:
        from hfc_design.batch.cluster import connected

        places = connected(workers, None, False, (None, None, None), lambda count: None)
    failed = run_batch(plan, out, workers or 1, places, anyway, on_cell)
    report(out, tell=lambda page, found: None)
    if failed:
        reasons = "; ".join(f"{name}: {reason}" for name, reason in failed.items())
        raise RunError(f"{out}: {len(failed)} of {len(plan.cells)} cells failed: {reasons}")
    return findings(out)


def findings(folder: str | Path) -> Findings:
    """What the runs below a folder give: groups over the seeds, their structures, how they compare.

    Raises:
        UserError: there is no such folder, or no run in it.
    """
    place = path_of(folder)
    return summed_up(place, runs_below(place))
