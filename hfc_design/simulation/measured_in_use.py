"""What is measured of a loop to tell whether it can be used, and what that says of each machine.

What is measured and what is read from it stand here together, because both go by the places of
the values.
"""

import numpy as np

from hfc_design.core.numbers import SAME_SINGLE, Floats, Gains, Mask
from hfc_design.files.design import Design
from hfc_design.files.doubts import LEAST_SAMPLES
from hfc_design.files.pairing import controller_of
from hfc_design.files.scenario import Scenario
from hfc_design.objectives.constraints import Constraint, constraints_on
from hfc_design.objectives.judge import Judged
from hfc_design.objectives.measures import MEASURES, Measure
from hfc_design.objectives.tolerances import TolerancesSettings, tolerated
from hfc_design.simulation.closed_loop import Loop, closed_loop
from hfc_design.simulation.in_use import InMotion
from hfc_design.simulation.settling import STABILITY, faults
from plants import in_a_name


def loop_in_use(
    design: Design, scenario: Scenario, later: float | None = None
) -> tuple[Loop, Gains]:
    """With all that tells whether it can be used measured; ``later`` is that of ``closed_loop``."""
    controller, gains = controller_of(design, scenario)
    loop = closed_loop(scenario, controller, later)
    own = tuple(one.measure for group in _measured(scenario) for one in group)
    return loop._replace(judge=loop.judge._replace(measured=own)), gains


def _measured(scenario: Scenario) -> list[list[Constraint]]:
    """Tolerances, constraints, what is told, and ``STABILITY``: the order of the values."""
    bounds = list(constraints_on(scenario.constraints, scenario.units))
    free = ([Constraint(one, np.inf) for one in some] for some in (_told(scenario), STABILITY))
    return [_tolerances(scenario), bounds, *free]


def _values(scenario: Scenario, judged: Judged) -> list[dict[str, tuple[Constraint, Floats]]]:
    """Of each part of ``_measured`` name -> bound, and (individuals, motions) what is measured."""
    values, groups = np.asarray(judged.values), _measured(scenario)
    columns = iter(np.moveaxis(values[..., -sum(map(len, groups)) :], -1, 0))
    return [{one.measure.name: (one, next(columns)) for one in group} for group in groups]


def units(scenario: Scenario) -> dict[str, str]:
    """In which each measure is told."""
    return {one.name: _unit(one, scenario) for one in _told(scenario)}


def _told(scenario: Scenario) -> tuple[Measure, ...]:
    tracking = "estimated_rms_contour_error" if scenario.follows_path else "settled_rms_error"
    return tuple(MEASURES[name] for name in (tracking, "chatter", "peak_command"))


def _unit(one: Measure, scenario: Scenario) -> str:
    return scenario.units.signals.get(one.unit, one.unit)


def not_kept(scenario: Scenario, judged: Judged) -> dict[str, Mask]:
    """Why individuals do not pass -> (individuals, motions) which; the nominal first."""
    failed = np.asarray(judged.failed)
    found = faults(np.asarray(judged.values), failed, scenario.each_motion())
    for name, (bound, values) in bounds_of(scenario, judged).items():
        found[f"exceeds {name}"] = ~(values <= bound.most * (1.0 + SAME_SINGLE)) & ~failed
    return found


def bounds_of(scenario: Scenario, judged: Judged) -> dict[str, tuple[Constraint, Floats]]:
    """Constraint -> itself, and (individuals, motions) what is measured."""
    return _values(scenario, judged)[1]


def _tolerances(scenario: Scenario) -> list[Constraint]:
    """What the scenario's fitness tolerates of single measures; nothing of another fitness."""
    own = scenario.fitness.on(scenario.units)
    if not isinstance(own, TolerancesSettings):
        return []
    return [Constraint(one, most) for one, most, _ in tolerated(own)]


def tolerated_metrics(scenario: Scenario) -> dict[str, tuple[Measure, str]]:
    """What the scenario's fitness tolerates, by such keys as metrics have; measures, meanings."""
    found = {}
    for one, _ in _tolerances(scenario):
        unit = " ".join(scenario.units.signals.get(word, word) for word in one.unit.split(" "))
        key = one.name if unit == "1" else f"{one.name}_{in_a_name(unit)}"
        found[key] = one, f"{one.meaning} [{unit}]"
    return found


def in_motion(scenario: Scenario, judged: Judged, k: int, motion: Scenario) -> InMotion:
    """What the machines do in motion ``k``; the nominal one is the first that was judged."""
    reasons = {why: mask[:, k] for why, mask in not_kept(scenario, judged).items()}
    tolerances, bounds, told, last = (
        {name: (own.most, values[:, k]) for name, (own, values) in part.items()}
        for part in _values(scenario, judged)
    )
    over = {}
    for name, (bound, _) in bounds_of(scenario, judged).items():
        most, values = bounds[name]
        unit = _unit(bound.measure, scenario)
        over[f"exceeds {name}"] = f" ({values[0]:.3g} {unit}, allowed {most:.3g})"
    bad = np.logical_or.reduce([*reasons.values()])
    why_not = [why + over.get(why, "") for why, mask in reasons.items() if mask[0]]
    if (steps := motion.simulation.steps) < LEAST_SAMPLES:
        needed = f"{steps} samples, {LEAST_SAMPLES} are needed"
        why_not.append(f"cannot be told to settle ({needed})")
    told["limit_share"] = last["limit_share"]
    return InMotion(
        motion.name.rpartition(".")[2] if scenario.motions else motion.name,
        ~bad[1:],
        {why: int(mask[1:].sum()) for why, mask in reasons.items() if mask[1:].any()},
        {name: column[1:] for name, (_, column) in told.items()},
        {name: float(column[0]) for name, (_, column) in told.items()},
        tuple(why_not),
        bounds,
        tolerances,
        not scenario.nominal_only[k],
    )
