"""What is measured of a loop to tell whether it can be used, and what that says of each machine.

What is measured and what is read from it stand here together, because both go by the places of
the values: first those of the constraints, then what is told, then ``STABILITY``.
"""

import numpy as np

from hfc_design.core.numbers import Floats, Gains, Mask
from hfc_design.files.design import Design
from hfc_design.files.pairing import controller_of
from hfc_design.files.scenario import Scenario
from hfc_design.objectives.constraints import Constraint, constraints_on
from hfc_design.objectives.judge import Judged
from hfc_design.objectives.measures import MEASURES, Measure
from hfc_design.simulation.closed_loop import Loop, closed_loop
from hfc_design.simulation.in_use import InMotion
from hfc_design.simulation.settling import STABILITY, faults


def loop_in_use(design: Design, scenario: Scenario) -> tuple[Loop, Gains]:
    """Constraints, what is told, and ``STABILITY`` are measured, in this order."""
    controller, gains = controller_of(design, scenario)
    loop = closed_loop(scenario, controller)
    bounds = constraints_on(scenario.constraints, scenario.units)
    own = (*(bound.measure for bound in bounds), *_measures(scenario), *STABILITY)
    return loop._replace(judge=loop.judge._replace(measured=own)), gains


def units(scenario: Scenario) -> dict[str, str]:
    """In which each measure is told."""
    return {one.name: _unit(one, scenario) for one in _measures(scenario)}


def _measures(scenario: Scenario) -> tuple[Measure, ...]:
    tracking = "rms_contour_error" if scenario.follows_path else "settled_rms_error"
    return tuple(MEASURES[name] for name in (tracking, "chatter", "peak_command"))


def _unit(one: Measure, scenario: Scenario) -> str:
    return scenario.units.signals.get(one.unit, one.unit)


def not_kept(scenario: Scenario, judged: Judged) -> dict[str, Mask]:
    """Why individuals do not keep everything -> (individuals, motions) which; the nominal first."""
    failed = np.asarray(judged.failed)
    found = faults(np.asarray(judged.values), failed, scenario.each_motion())
    for name, (bound, values) in _bounds(scenario, judged).items():
        found[f"breaks {name}"] = ~(values <= bound.most) & ~failed
    return found


def _bounds(scenario: Scenario, judged: Judged) -> dict[str, tuple[Constraint, Floats]]:
    """Constraint -> itself, and (individuals, motions) what is measured."""
    bounds = constraints_on(scenario.constraints, scenario.units)
    values = np.asarray(judged.values)
    first = values.shape[-1] - len(STABILITY) - len(_measures(scenario)) - len(bounds)
    return {own.measure.name: (own, values[..., first + n]) for n, own in enumerate(bounds)}


def in_motion(scenario: Scenario, judged: Judged, k: int, motion: Scenario) -> InMotion:
    """What the machines do in motion ``k``; the nominal one is the first that was judged."""
    reasons = {why: mask[:, k] for why, mask in not_kept(scenario, judged).items()}
    bounds = {
        name: (own, values[:, k]) for name, (own, values) in _bounds(scenario, judged).items()
    }
    over = {}
    for name, (bound, values) in bounds.items():
        unit = _unit(bound.measure, scenario)
        over[f"breaks {name}"] = f" ({values[0]:.3g} {unit}, allowed {bound.most:.3g})"
    bad = np.logical_or.reduce([*reasons.values()])
    own = _measures(scenario)
    first = judged.values.shape[-1] - len(STABILITY) - len(own)
    values = np.asarray(judged.values)[:, k]
    columns = {one.name: values[:, first + n] for n, one in enumerate(own)}
    limited = [one.name for one in STABILITY].index("limit_share") - len(STABILITY)
    columns["limit_share"] = values[:, limited]
    return InMotion(
        motion.name.rpartition(".")[2] if scenario.motions else motion.name,
        ~bad[1:],
        {why: int(mask[1:].sum()) for why, mask in reasons.items() if mask[1:].any()},
        {name: column[1:] for name, column in columns.items()},
        {name: float(column[0]) for name, column in columns.items()},
        tuple(why + over.get(why, "") for why, mask in reasons.items() if mask[0]),
        {name: (own.most, values) for name, (own, values) in bounds.items()},
        not scenario.nominal_only[k],
    )
