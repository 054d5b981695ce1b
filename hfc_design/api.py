"""The package for scripts, in one import: ``import hfc_design.api as hfc``.

It loads scenarios, designs controllers, evaluates and exports them; it also adds your own plants,
fitnesses, strategies and control laws. ``docs/python.md`` and ``docs/notebooks`` have examples.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, TypeVar

from hfc_design.attainable.attainable import Attainable, attainable
from hfc_design.batch.findings import Findings
from hfc_design.calls.batching import batch, findings
from hfc_design.calls.circling import circle
from hfc_design.calls.exchanging import export, import_
from hfc_design.calls.frequency import frequency
from hfc_design.calls.identifying import check, experiment, identify
from hfc_design.calls.laps import laps
from hfc_design.calls.searching import design, pick, with_gains
from hfc_design.calls.showing import comparison_page, explain, plot, report
from hfc_design.calls.stability import stability
from hfc_design.controllers.controller import AxisLaw, View, held
from hfc_design.controllers.gains import Law, settings_of
from hfc_design.controllers.gains.genome import GainsGenome as genome_of_gains
from hfc_design.controllers.genome import Genome, taken
from hfc_design.controllers.kind import (
    ControllerRecord,
    ControllerSettings,
    Explain,
    ReportContext,
    Target,
    later,
)
from hfc_design.controllers.neural.record import Lesson
from hfc_design.core.numbers import Constant, Xp, clipped, total
from hfc_design.core.plugins import group_of
from hfc_design.core.records import RunError, UserError
from hfc_design.core.tables import Table
from hfc_design.files.design import Design
from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.scenario import Scenario
from hfc_design.identify.checking import Check
from hfc_design.identify.experiment import Experiment
from hfc_design.identify.identified import Identified
from hfc_design.objectives.objective import Moment, Objective, ObjectiveSettings
from hfc_design.plotting.section import Drawing, Section
from hfc_design.report.circle import CircleTest
from hfc_design.report.designs import picture
from hfc_design.report.laps import Laps
from hfc_design.runs.run import Result
from hfc_design.runtime import Controller
from hfc_design.search.loop import STRATEGIES, Search
from hfc_design.search.strategy import Strategy, StrategySettings, Task
from hfc_design.simulation.acceptance import Usable
from hfc_design.simulation.comparison import Comparison, compare
from hfc_design.simulation.ensemble import Judgements, evaluate_many
from hfc_design.simulation.evaluating import Evaluation, evaluate, learned_in, trajectory_csv
from hfc_design.simulation.imitation import Taught, taught
from hfc_design.simulation.monte_carlo import Robustness, robustness
from hfc_design.simulation.usable import usable
from hfc_design.stability.frequency import Frequencies
from hfc_design.stability.report import LoopMargins, StableGains
from plants import Drive, Machine, coupled, only_positive, rk4, side_by_side

Listing = Table
"""The name that a table of a section had before."""
Shown = ReportContext
"""The name that the context of a report had before."""
Plant = Drive
"""The name that a drive had before machines had several of them."""
Fitness = Objective
"""What objectives are called where a scenario names one."""
strategies: Mapping[str, Strategy] = MappingProxyType(STRATEGIES.known)
"""Name -> search strategy, of those that are built in or registered."""
Registered = TypeVar("Registered")


def __dir__() -> list[str]:
    """Return the names for scripts, for completion; not those that only this module uses."""
    return sorted(__all__)


def __getattr__(name: str) -> Any:
    if name == "Kind":
        message = (
            "a kind is now a subclass of ControllerRecord, with the functions of Kind as methods"
        )
        raise AttributeError(f"hfc_design.api.Kind is gone: {message}; see docs/python.md")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def register(thing: Registered) -> Registered:
    """Register your own part, so that scenarios and designs of this program can name it.

    A part is a drive or machine, a fitness, a search strategy, a control law or a controller kind.

    Raises:
        UserError: ``thing`` is none of these, has a fault, or has the name of a built-in part.
    """
    group_of(thing).add(thing)
    return thing


# Loading, and its errors.
__all__ = ["Design", "Scenario", "load_design", "load_scenario"]
__all__ += ["RunError", "UserError"]
# A machine identified from its log.
__all__ += ["Check", "Experiment", "Identified", "check", "experiment", "identify"]
# A circular test of a machine, or of a design.
__all__ += ["CircleTest", "circle"]
# A controller that is searched, picked from a front, made by hand, or taught.
__all__ += ["Result", "Search", "design", "pick", "strategies", "with_gains"]
__all__ += ["Lesson", "Taught", "taught"]
# Evaluation, robustness, stability, comparison, best attainable result, batches.
__all__ += ["Evaluation", "evaluate", "learned_in", "trajectory_csv"]
__all__ += ["Robustness", "Usable", "robustness", "usable"]
__all__ += ["Frequencies", "Laps", "frequency", "laps"]
__all__ += ["LoopMargins", "StableGains", "stability"]
__all__ += ["Comparison", "compare"]
__all__ += ["Judgements", "evaluate_many"]
__all__ += ["Attainable", "attainable"]
__all__ += ["Findings", "batch", "findings"]
# Figures, pages and explanations.
__all__ += ["comparison_page", "explain", "picture", "plot", "report"]
# Export to other programs, and import.
__all__ += ["Controller", "export", "import_"]
# A user's own parts, and what they are made of.
__all__ += ["register"]
__all__ += ["Drive", "Machine", "Plant", "coupled", "only_positive", "rk4", "side_by_side"]
__all__ += ["Fitness", "Moment", "Objective", "ObjectiveSettings"]
__all__ += ["Genome", "Strategy", "StrategySettings", "Task", "taken"]
__all__ += ["AxisLaw", "Law", "View", "genome_of_gains", "held", "settings_of"]
__all__ += ["ControllerRecord", "ControllerSettings", "Explain", "later"]
__all__ += ["Drawing", "Listing", "ReportContext", "Section", "Shown", "Table", "Target"]
__all__ += ["Constant", "Xp", "clipped", "total"]
