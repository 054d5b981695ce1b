"""What is measured of a loop to tell whether it can be used, and what that says of each machine.

What is measured and what is read from it stand here together, because both go by the places of
the values: first those of the scenario's own tolerances, then those of the constraints, then what
is told, then ``STABILITY``.
"""

from collections.abc import Sequence

import numpy as np

from hfc_design.core.numbers import SAME_SINGLE, Floats, Gains, Mask
from hfc_design.files.design import Design
from hfc_design.files.pairing import controller_of
from hfc_design.files.scenario import Scenario
from hfc_design.objectives.constraints import Constraint, constraints_on
from hfc_design.objectives.judge import Judged
from hfc_design.objectives.measures import MEASURES, Measure
from hfc_design.objectives.tolerances import TolerancesSettings, tolerated
from hfc_design.simulation.closed_loop import Loop, closed_loop
from hfc_design.simulation.one_motion import InMotion
from hfc_design.simulation.settling import STABILITY, faults
from plants import in_a_name


def loop_in_use(
    design: Design, scenario: Scenario, later: float | None = None
) -> tuple[Loop, Gains]:
    """Tolerances, constraints, what is told, and ``STABILITY`` are measured, in this order.

    ``later`` is that of ``closed_loop``.
    """
    controller, gains = controller_of(design, scenario)
    loop = closed_loop(scenario, controller, later)
    bounds = [*_tolerances(scenario), *constraints_on(scenario.constraints, scenario.units)]
    own = (*(bound.measure for bound in bounds), *_measures(scenario), *STABILITY)
    return loop._replace(judge=loop.judge._replace(measured=own)), gains


def units(scenario: Scenario) -> dict[str, str]:
    """In which each measure is told."""
    return {one.name: _unit(one, scenario) for one in _measures(scenario)}


def _measures(scenario: Scenario) -> tuple[Measure, ...]:
    tracking = "estimated_rms_contour_error" if scenario.follows_path else "settled_rms_error"
    return tuple(MEASURES[name] for name in (tracking, "chatter", "peak_command"))


def _unit(one: Measure, scenario: Scenario) -> str:
    return scenario.units.signals.get(one.unit, one.unit)


def not_kept(scenario: Scenario, judged: Judged) -> dict[str, Mask]:
    """Why individuals do not pass -> (individuals, motions) which; the nominal first."""
    failed = np.asarray(judged.failed)
    found = faults(np.asarray(judged.values), failed, scenario.each_motion())
    for name, (bound, values) in _bounds(scenario, judged).items():
        found[f"exceeds {name}"] = ~(values <= bound.most * (1.0 + SAME_SINGLE)) & ~failed
    return found


def _bounds(scenario: Scenario, judged: Judged) -> dict[str, tuple[Constraint, Floats]]:
    """Constraint -> itself, and (individuals, motions) what is measured."""
    bounds = constraints_on(scenario.constraints, scenario.units)
    return _measured_before(bounds, len(_measures(scenario)) + len(STABILITY), judged)


def _measured_before(
    bounds: Sequence[Constraint], after: int, judged: Judged
) -> dict[str, tuple[Constraint, Floats]]:
    """Name -> bound and (individuals, motions) values, which ``after`` others come behind."""
    values = np.asarray(judged.values)
    first = values.shape[-1] - after - len(bounds)
    return {own.measure.name: (own, values[..., first + n]) for n, own in enumerate(bounds)}


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
    bounds = {
        name: (own, values[:, k]) for name, (own, values) in _bounds(scenario, judged).items()
    }
    after = len(bounds) + len(_measures(scenario)) + len(STABILITY)
    tolerances = _measured_before(_tolerances(scenario), after, judged)
    over = {}
    for name, (bound, values) in bounds.items():
        unit = _unit(bound.measure, scenario)
        over[f"exceeds {name}"] = f" ({values[0]:.3g} {unit}, allowed {bound.most:.3g})"
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
        {name: (own.most, each[:, k]) for name, (own, each) in tolerances.items()},
        not scenario.nominal_only[k],
    )
