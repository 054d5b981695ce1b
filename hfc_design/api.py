"""The package for scripts, in one import: ``import hfc_design.api as hfc``.

Load a scenario, design, evaluate, export; add an own plant, fitness, strategy or control law.
``docs/python.md`` shows all of it at work.
"""

from collections.abc import Callable, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, TypeVar

from hfc_design.attainable.attainable import Attainable, attainable
from hfc_design.controllers.controller import AxisLaw, View, held
from hfc_design.controllers.gains import Law, genome_of_gains, settings_of
from hfc_design.controllers.genome import Genome, taken
from hfc_design.controllers.kind import (
    ControllerRecord,
    ControllerSettings,
    Explain,
    Kind,
    Member,
    Saved,
    Shown,
    Target,
    Template,
)
from hfc_design.controllers.kinds import KINDS
from hfc_design.controllers.neural.training import Lesson
from hfc_design.core.arguments import path_of, wanted
from hfc_design.core.lock import alone
from hfc_design.core.numbers import Xp, clipped, total
from hfc_design.core.plugins import group_of
from hfc_design.core.records import RunError, UserError
from hfc_design.core.wording import one_of
from hfc_design.files.design import AnyDesign, Design
from hfc_design.files.named_scenario import AnyScenario, load_scenario, renamed
from hfc_design.files.pairing import load_design
from hfc_design.files.scenario import Scenario
from hfc_design.formats import FORMATS, check_score
from hfc_design.objectives.objective import Moment, Objective, ObjectiveSettings
from hfc_design.pictures.figure import Drawing, Listing, Section
from hfc_design.runs.front import chosen
from hfc_design.runs.individuals import design_with
from hfc_design.runs.problem import check_memory
from hfc_design.runs.run import (
    CONFIG,
    Result,
    finished_run,
    front_needed,
    new_run,
    opened_run,
    picked,
    run,
)
from hfc_design.runtime import Controller
from hfc_design.runtime.explain import explained
from hfc_design.search.loop import STRATEGIES, Search
from hfc_design.search.strategy import Strategy, StrategySettings, Task
from hfc_design.simulation.comparing import compare
from hfc_design.simulation.comparison import Comparison
from hfc_design.simulation.ensemble import Judgements, evaluate_many
from hfc_design.simulation.evaluating import evaluate, learned_in
from hfc_design.simulation.evaluation import EVALUATED, Evaluation, trajectory_csv
from hfc_design.simulation.monte_carlo import Robustness, robustness
from hfc_design.simulation.teaching import Taught, taught
from plants import Drive, Machine, coupled, only_positive, rk4, side_by_side

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Plant = Drive
"""The name that a drive had before machines had several of them."""
Fitness = Objective
"""What objectives are called where a scenario names one."""
strategies: Mapping[str, Strategy] = MappingProxyType(STRATEGIES.known)
"""Name -> search strategy, of those that are built in or registered."""
Registered = TypeVar("Registered")


def register(thing: Registered) -> Registered:
    """Let scenarios and designs of this program name an own part.

    A drive or machine, a fitness, a search strategy, a control law or a kind of controller.

    Raises:
        UserError: it is none of these, lacks something, or its name is that of a built-in one.
    """
    group_of(thing).add(thing)
    return thing


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
            own = new_run(scenario, Path(name))
            return run(own, Path(name), on_generation)
    from hfc_design.report.page import write_page

    check_memory(scenario)
    place = path_of(folder)
    with alone(place):
        if (place / CONFIG).exists():
            own = opened_run(place)
            # The folder holds copies of the files that a scenario names.
            one, other = (renamed(x, lambda key, file: Path(key)) for x in (own, scenario))
            if one != other:
                raise UserError(f"{place}: holds a run of another scenario; name another folder")
        else:
            own = new_run(scenario, place)
        result = run(own, place, on_generation, anyway)
        write_page(own, result, place)
        return result


def pick(
    folder: str | Path, point: int | None = None, nearest: Mapping[str, float | str] | None = None
) -> Design:
    """The design of a point of the front that the run in a folder has found.

    That of a number in its ``front.csv``, the one nearest to costs (objective -> a number or a
    text with a unit), or else the knee.

    Raises:
        UserError: there is no finished run, no front, or no such point.
        RunError: a file of the run is damaged.
    """
    place = path_of(folder)
    scenario, result = finished_run(place)
    front = front_needed(place, result)
    return picked(scenario, result, chosen(front, scenario, point, nearest))[0]


def with_gains(scenario: AnyScenario, kind: str, gains: Mapping[str, Any]) -> Design:
    """A design by hand: a controller of kind pd, pid, pid+ff or an own law with these gains.

    Raises:
        UserError: no such kind, or it has other gains.
    """
    of_gains = KINDS.get(kind).of_gains
    if of_gains is None:
        raise UserError(f"a controller of kind {kind} is no list of gains")
    wanted(gains, Mapping, "table of gains and their values")
    return design_with({"kind": kind, **of_gains(dict(gains))}, load_scenario(scenario))


def export(found: AnyDesign, to: str, path: str | Path, anyway: bool = False) -> Path:
    """Write a design in a format, "json" for the design file itself; see ``hfc list formats``.

    Raises:
        UserError: no such format, or not for this kind of controller; or the design's score says
            that it diverged, and it is not wanted ``anyway``.
        RunError: ``path`` cannot be written.
    """
    if to not in [*FORMATS]:  # which need not be a text
        raise UserError(f"{to!r} is no format; {one_of(to, FORMATS)}")
    place, design = path_of(path), load_design(found)
    check_score(design, anyway)
    FORMATS[to].write(design, place)
    return place


def plot(evaluation: Evaluation, path: str | Path, title: str = "") -> Path:
    """Draw the motion to a png, svg or pdf file.

    Raises:
        UserError: it is no evaluation, or there is no such kind of file.
        RunError: ``path`` cannot be written.
    """
    from hfc_design.pictures.figure import save
    from hfc_design.report.plots import motion

    wanted(evaluation, Evaluation, EVALUATED)
    place = path_of(path)
    save(motion(evaluation, title), place)
    return place


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
    texts = [
        one if isinstance(one, str) else ",".join(f"{name}={x}" for name, x in one.items())
        for one in samples
    ]
    return explained(load_design(found), texts, axis)


def import_(path: str | Path, **wish: Any) -> Design:
    """A design of another program's controller file, as ``hfc import`` makes it.

    ``wish`` has what ``formats.reading.Wish`` does: ``plant`` and ``like`` by name,
    ``signals`` {input of the file: signal}, ``sample_time`` [s], ``terms`` (rows, columns).

    Raises:
        UserError: the file cannot be read, or holds what a design cannot.
    """
    from hfc_design.formats.reading import Wish, imported

    if unknown := sorted(wish.keys() - {*Wish._fields}):
        raise UserError(
            f"import_: no such option {unknown[0]!r}; there is {', '.join(Wish._fields)}"
        )
    return imported(Path(path), Wish(**wish))


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


def comparison_page(comparison: Comparison, path: str | Path) -> Path:
    """Write the page of a comparison, one file with everything inside it.

    Raises:
        UserError: it is no comparison.
        RunError: ``path`` cannot be written.
    """
    from hfc_design.core.checkpoint import write_whole
    from hfc_design.report.comparison.page import page

    wanted(comparison, Comparison, "comparison; compare(designs) makes one")
    place = path_of(path)
    write_whole(place, page(comparison))
    return place


# Parts of one's own, and what they are made of.
__all__ = ["AxisLaw", "ControllerRecord", "ControllerSettings", "Drawing", "Drive", "Explain"]
__all__ += ["Fitness", "Genome", "Kind", "Law", "Listing", "Machine", "Member", "Moment"]
__all__ += [
    "Objective",
    "ObjectiveSettings",
    "Plant",
    "Saved",
    "Section",
    "Shown",
    "Strategy",
    "StrategySettings",
]
__all__ += ["Target", "Task", "Template", "View", "Xp", "clipped", "coupled", "genome_of_gains"]
__all__ += ["held", "only_positive", "register", "rk4", "settings_of", "side_by_side"]
__all__ += ["strategies", "taken", "total"]
# What is loaded, searched, evaluated and written.
__all__ += [
    "Attainable",
    "Comparison",
    "Controller",
    "Design",
    "Evaluation",
    "Judgements",
    "Lesson",
    "Result",
    "Taught",
]
__all__ += ["Robustness", "RunError", "Scenario", "Search", "UserError", "attainable", "compare"]
__all__ += [
    "comparison_page",
    "design",
    "evaluate",
    "evaluate_many",
    "explain",
    "export",
    "import_",
    "learned_in",
]
__all__ += [
    "load_design",
    "load_scenario",
    "pick",
    "picture",
    "plot",
    "robustness",
    "taught",
    "trajectory_csv",
    "with_gains",
]
