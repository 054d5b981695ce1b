"""What a design achieves beside the published ones, in a sentence."""

import re
from typing import NamedTuple

import numpy as np

from hfc_design.files.pairing import load_design, machine, own_scenario
from hfc_design.files.scenario import Scenario
from hfc_design.pictures.numbers import score
from hfc_design.report.comparison.tables import short
from hfc_design.simulation.evaluating import Evaluation
from hfc_design.simulation.repeats import range_told

Evaluations = dict[str, Evaluation]  # by the names of the designs
#: What a meaning has between brackets: a signal of the machine, or a unit.
SIGNAL = re.compile(r"(?<=\[)\w+(?=\])")


class Baseline(NamedTuple):
    """What a published design is called."""

    short: str  # in the table
    name: str = ""  # in the summary; "": it is not compared with there
    nominal: bool = False  # it was tuned for one machine, and says nothing of another


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
        ),
    },
}


def baselines(scenario: Scenario) -> dict[str, Baseline]:
    """The published designs that the machine of a scenario is for, by their names."""
    known = BASELINES.get(scenario.plant.name, {})
    return {k: one for k, one in known.items() if not one.nominal or _at_home(k, scenario)}


def _at_home(name: str, scenario: Scenario) -> bool:
    """Whether a scenario has the machine that a published design was made for."""
    design = load_design(name)
    return machine(design, own_scenario(design, name)).values() == scenario.plant.values()


def summary(scenario: Scenario, own: Evaluation, rivals: Evaluations, yes: bool = True) -> str:
    """What the run achieved, in a sentence.

    Beside published designs only where the design can be used, ``yes``, and on their own machine.
    """
    if own.diverged:
        return f"The controller diverges on {scenario.name}{_why(own)}."
    achieved = f"a fitness of {_fitness(own)[1]}"
    if own.contour is not None:
        achieved = f"a contour error of {_rms(own):.3g} {own.contour.unit} rms"
    line = f"The controller reaches {achieved} on {scenario.name}"
    if own.substeps > scenario.simulation.substeps:
        line += f" (simulated with {own.substeps} substeps, it diverges with fewer)"
    known = baselines(scenario) if yes else {}
    names = {key: known[key].name for key in known if key in rivals and _at_home(key, scenario)}
    parts = [_compared(own, rivals[key], name) for key, name in names.items() if name]
    if not parts:
        return f"{line}."
    *others, last = parts
    return f"{line}: {', '.join(others)}{' and ' if others else ''}{last}."


def _compared(own: Evaluation, rival: Evaluation, name: str) -> str:
    if rival.diverged:
        return f"{name} diverges there{_why(rival)}"
    if own.contour is None:
        mine, (theirs, told) = _fitness(own)[0], _fitness(rival)
        if min(mine, theirs) <= 0.0:
            return f"that of {name} is {told}"
        return f"{short(mine / theirs)} times that of {name} ({told})"
    its = f"{_rms(rival):.3g} {own.contour.unit}"
    factor = _rms(rival) / _rms(own) if _rms(own) else np.inf
    if not 0 < factor < np.inf:
        return f"that of {name} is {its}"
    return f"that of {name} is {short(factor)} times as large ({its})"


def _fitness(found: Evaluation) -> tuple[float, str]:
    """What it counts as, where it is chaotic its lower end, and how people read it."""
    if (many := found.ranges.get("fitness")) is None:
        return found.fitness, score(found.fitness)
    return found.repeats["fitness"].lowest, range_told(many)


def _why(lost: Evaluation) -> str:
    return f": {lost.divergence}" if lost.divergence else ""


def _rms(found: Evaluation) -> float:
    """Root mean square of the contour error of a motion that did not diverge."""
    value = next(iter(found.metrics.values()))
    return np.inf if value is None else value  # too large for its square


def measure(scenario: Scenario) -> str:
    """What the fitness is, and what designs are ranked by."""
    judge = scenario.judge()
    tail = f"; designs are ranked by {judge.title}" if "merit" in judge.titles else ""
    return fitness_told(scenario) + tail


def fitness_told(scenario: Scenario) -> str:
    """What the fitness is, with the units of the machine."""
    fitness, units = scenario.judge().objectives[0], scenario.units.signals
    meaning = fitness.meaning or f"{fitness.name}, an own one"
    return f"The fitness is {SIGNAL.sub(lambda x: units.get(x[0], x[0]), meaning)}"
