"""Parts of the page of a design: usability, bounds, structures, the controller."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hfc_design.controllers.kind import ReportContext
from hfc_design.core.numbers import Json
from hfc_design.core.plugins import own_code
from hfc_design.core.records import RunError, UserError
from hfc_design.core.tables import MISSING, Table
from hfc_design.files.design import Design
from hfc_design.files.loop_setup import load_design, machine, own_scenario
from hfc_design.files.machine import SensorSettings
from hfc_design.files.scenario import Scenario
from hfc_design.objectives.constraints import constraints_on
from hfc_design.plotting.numbers import digits, score
from hfc_design.plotting.section import Drawing, Section
from hfc_design.report.comparison.tables import titled
from hfc_design.runs.attained import attained_table, attained_told, kept_attained
from hfc_design.runs.individuals import genome_of
from hfc_design.search.loop import Archive
from hfc_design.simulation.evaluating import Evaluation, first_metrics, meanings, score_rows
from hfc_design.simulation.loop_margins import loop_margins
from hfc_design.simulation.repeats import range_text

Evaluations = dict[str, Evaluation]  # by the names of the designs

#: Number of listed structures.
BEST = 10
#: Content of brackets in a meaning: a signal of the machine, or a unit.
SIGNAL = re.compile(r"(?<=\[)\w+(?=\])")


def score_tables(scenario: Scenario, evaluations: Evaluations) -> list[Table]:
    """Return a table of ``first_metrics`` and one of all others, a column for each design."""
    results, texts = [*evaluations.values()], meanings(scenario)
    rows = score_rows(scenario.judge(), results)
    for key in rows.keys() & texts:
        values = [one.metrics[key] for one in results]
        name, factor = titled(key, texts[key], values)
        rows[key] = [name, *(MISSING if x is None else digits(factor * x) for x in values)]
    first, head = first_metrics(scenario, results[0]), ["metric", *evaluations]
    about = f"All on the same scenario. {measure(scenario)}; a dash means no value."
    shown, others = (
        [row for key, row in rows.items() if (key in first) is x] for x in (True, False)
    )
    return [Table(about, head, shown), Table("All other metrics.", head, others)]


def whether_used(numbers: Callable[[], Json]) -> Json | None:
    """Return the usability of a design; None if unknown. RunError: the stored one is damaged."""
    try:
        return numbers()
    except RunError:
        raise
    except UserError:
        return None


def pass_conditions(scenario: Scenario) -> str:
    """Conditions that a machine has to meet to pass, in words."""
    bounds = constraints_on(scenario.constraints, scenario.units)
    if not bounds:
        return (
            "the loop is stable. Only stability is tested: this scenario sets no limits, so a poor "
            "controller may pass"
        )
    units = scenario.units.signals
    limits = (
        f"{one.metric.name} of {one.most:g} [{units.get(one.metric.unit, one.metric.unit)}]"
        for one in bounds
    )
    return f"the loop is stable, and has at most {', '.join(limits)}"


def how_near(folder: Path) -> Json | None:
    """Comparison of the design with the best attainable control; None if it was not computed."""
    attained = kept_attained(folder)
    return attained and {"told": attained_told(attained), "table": attained_table(attained)}


def best_structures(archive: Archive, scenario: Scenario) -> Table | None:
    """The best structures of the search and their scores; None if there is only one."""
    genome = genome_of(scenario)
    if genome.structures == 1:
        return None
    best = (-archive.score).argsort(kind="stable")[:BEST]
    order = best[np.isfinite(archive.score[best])]
    trees = archive.population.tree
    return Table(
        "The best structures, each with its best merit in the search (in "
        f"{scenario.run.precision}); the controller of the run is the best of them in "
        "float64. A unit is written (column input, row input).",
        ["structure", scenario.judge().title],
        [[genome.notation(int(trees[k])), score(archive.score[k])] for k in order],
    )


def sections(design: Design, evaluation: Evaluation, scenario: Scenario) -> list[Section]:
    """Return sections on the controller and its loop; UserError: a user's own kind fails."""
    plant = scenario.plant
    # If the scenario has sensors of its own, the signals that the control measures are unknown.
    known = scenario.sensors == SensorSettings() and not evaluation.diverged
    signals = {axis.name: axis.sensed() for axis in evaluation.axes} if known else None
    largest = tuple(design.limits.of(axis).command for axis in plant.machine.axes)
    shown = ReportContext(plant.machine, plant.values(), signals, largest)
    kinds = [("controller", part.kind.name) for part in (design, *design.by_axis().values())]
    with own_code(", sections of the report (the design is saved)", *kinds):
        listed = [Section(*section) for section in design.kind.sections(design.controller, shown)]
    return [*listed, _loop(design, scenario)]


def _loop(design: Design, scenario: Scenario) -> Section:
    """Return a section with the margins and the response of the loop as simulated."""
    title = "The loop"
    try:
        margins = loop_margins(design, scenario)
    except UserError as error:
        return Section(title, f"{error.typed}.", None, [])
    drawing = Drawing(
        margins.figure(),
        "Magnitude and phase of the open loop, its sensitivity, and the closed loop",
        "The open loop from command to command, and the factor by which feedback "
        "amplifies a disturbance.",
    )
    (table,) = margins.tables()
    why = " ".join(f"{line}." for line in table.lines)
    return Section(title, why, table, [] if margins.stable is None else [drawing])


class Baseline(NamedTuple):
    """Names of a published design."""

    short: str  # in the table
    name: str = ""  # in the summary; "": it is not mentioned there
    nominal: bool = False  # True: tuned for one machine, and not shown on others


#: Plant -> built-in designs shown beside every result.
BASELINES = {
    "five-axis": {"lin-gai-2009-pid": Baseline("LG PID", "the PID of Lin & Gai (2009)")},
    "c-axis": {
        "lin-lee-1999-table-1": Baseline("LL Table I", "Table I of Lin & Lee (1999)"),
        "lin-lee-1999-table-2": Baseline("LL Table II", "Table II"),
        "pd-only": Baseline("PD only"),
    },
    "feed-drive": {
        "jee-koren-2004-aflc": Baseline("JK04 AFLC", "the AFLC of Jee & Koren (2004)"),
        "jee-koren-2004-flc": Baseline("JK04 FLC", "their FLC"),
        "jee-koren-2004-pid": Baseline("JK04 PID", "their PID"),
    },
    "milling-table": {
        "huang-soc": Baseline("Huang SOC", "the SOC of Huang & Shy"),
        "huang-pid": Baseline("Huang PID", "their PID"),
    },
    "positioning-stage": {
        "emps-cascade": Baseline(
            "EMPS cascade", "the loop that recorded the logs of EMPS", nominal=True
        )
    },
}


def baselines(scenario: Scenario) -> dict[str, Baseline]:
    """The published designs for the machine of a scenario, by their names."""
    known = BASELINES.get(scenario.plant.name, {})
    return {k: one for k, one in known.items() if not one.nominal or _at_home(k, scenario)}


def _at_home(name: str, scenario: Scenario) -> bool:
    """True if a scenario has the machine that a published design was made for."""
    design = load_design(name)
    return machine(design, own_scenario(design, name)).values() == scenario.plant.values()


def summary(
    scenario: Scenario, evaluation: Evaluation, rivals: Evaluations, yes: bool = True
) -> str:
    """Return the result of the run in words.

    Published designs are mentioned only if ``yes`` (the design is usable), on their own machine.
    """
    if evaluation.diverged:
        return f"The controller diverges on {scenario.name}{_why(evaluation)}."
    achieved = f"a fitness of {_fitness(evaluation)}"
    if evaluation.contour is not None:
        achieved = f"a contour error of {_rms(evaluation):.3g} {evaluation.contour.unit} rms"
    line = f"The controller reaches {achieved} on {scenario.name}"
    if evaluation.substeps > scenario.simulation.substeps:
        line += f" (simulated with {evaluation.substeps} substeps, it diverges with fewer)"
    known = baselines(scenario) if yes else {}
    names = {key: known[key].name for key in known if key in rivals and _at_home(key, scenario)}
    parts = [_compared(evaluation, rivals[key], name) for key, name in names.items() if name]
    if not parts:
        return f"{line}."
    return f"{line}. For comparison: {', '.join(parts)}."


def _compared(evaluation: Evaluation, rival: Evaluation, name: str) -> str:
    if rival.diverged:
        return f"{name} diverges there{_why(rival)}"
    if evaluation.contour is None:
        return f"{name} {_fitness(rival)}"
    return f"{name} {_rms(rival):.3g} {evaluation.contour.unit}"


def _fitness(evaluation: Evaluation) -> str:
    """Return the text of the fitness; a range if the loop is chaotic."""
    many = evaluation.ranges.get("fitness")
    return score(evaluation.fitness) if many is None else range_text(many)


def _why(lost: Evaluation) -> str:
    return f": {lost.divergence}" if lost.divergence else ""


def _rms(evaluation: Evaluation) -> float:
    """Return the rms contour error of a motion that did not diverge."""
    value = next(iter(evaluation.metrics.values()))
    return np.inf if value is None else value  # None: the squares overflow


def measure(scenario: Scenario) -> str:
    """Definition of the fitness, and the number that ranks designs."""
    judge = scenario.judge()
    tail = f"; designs are ranked by {judge.title}" if "merit" in judge.titles else ""
    return fitness_told(scenario) + tail


def fitness_told(scenario: Scenario) -> str:
    """Definition of the fitness, with the units of the machine."""
    fitness, units = scenario.judge().objectives[0], scenario.units.signals
    meaning = fitness.meaning or f"{fitness.name}, defined in your code"
    return f"The fitness is {SIGNAL.sub(lambda x: units.get(x[0], x[0]), meaning)}"
