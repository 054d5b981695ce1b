"""Best attainable control of a C-axis: a certified bound of sum |e|, a voltage close to it."""

from typing import NamedTuple

import numpy as np

from hfc_design.attainable.certificate import Bounds, Certified, certified
from hfc_design.attainable.linear_model import (
    ANGLE,
    LinearModel,
    Sampled,
    linear_model,
    sampled,
    undriven,
)
from hfc_design.attainable.linear_program import Linear, LinearProgram, Solved, linear_program
from hfc_design.attainable.open_loop import best_voltage
from hfc_design.attainable.reachable import reachable
from hfc_design.attainable.rollout import RolledOut, Rollout, rollout_of
from hfc_design.attainable.sliding import Case, bent, speeds
from hfc_design.core import devices
from hfc_design.core.numbers import Floats, Json
from hfc_design.core.records import RunError, UserError, option
from hfc_design.files.named_scenario import AnyScenario, load_scenario
from hfc_design.files.scenario import Scenario
from plants import C_AXIS
from plants.c_axis import CAxisState

#: Samples behind the first error of a motion that are evaluated, and their largest number.
SAMPLES, MOST_SAMPLES = 256, 1024
#: If the last quarter of them has more than this share of the sum of errors, they are doubled.
LATE = 0.005
#: Largest number of rounds with bounds on the speed, number of such bounds in a round, and share by
#: which it must raise the result. The bounds end where the errors of the known motion have added up
#: to the last share.
ROUNDS, ASKED, RISE, MOSTLY = 3, 16, 0.01, 0.99
#: Samples behind the last of these bounds whose errors still count in these rounds.
AFTER = 24


class Attainable(NamedTuple):
    """Results for one motion; sums of ``|e|`` over all its samples [rad]."""

    name: str
    bound: float  # no controller has a smaller sum
    simple: float  # the same before anything is known of the spindle's direction
    reached: float  # by the best voltage that was found
    samples: int  # number of samples in the bound; errors of later ones count as 0
    allowance: float  # for rounding and for bristles within a sample, subtracted in the bound
    voltage: Floats  # (steps,) that gives ``reached`` [V]

    def numbers(self) -> Json:
        """Return all fields except name and voltage, for JSON."""
        keys = ("bound", "simple", "reached", "allowance")
        return {key: float(getattr(self, key)) for key in keys} | {"samples": self.samples}


def check(scenario: Scenario) -> None:
    """Check that a bound exists for a scenario.

    Raises:
        UserError: there is no bound, with the reason.
    """
    machine = scenario.plant.machine
    if len(machine.drives) != 1 or machine.drives[0] is not C_AXIS or machine.forces:
        only = f"a bound exists only for a machine with one {C_AXIS.name}"
        raise UserError(f"scenario {scenario.name} has the plant {machine.name}: {only}")
    if scenario.limits.of(machine.axes[0]).command is None:
        raise UserError(
            f"scenario {scenario.name} has no limits.command: without one there is no bound, a "
            "voltage that is large enough leaves next to no error; try "
            + option("set", 250, "changes", "limits.command")
        )


def attainable(scenario: AnyScenario) -> dict[str, Attainable]:
    """Return bound and best known voltage of every motion of a scenario, by the motion's name.

    They hold for the nominal machine with ideal sensors, and for a controller that may know
    everything beforehand, load and friction too; it is limited only by the voltage, and by whole
    samples of delay if the scenario has a delay.

    Raises:
        UserError: the scenario has no bound.
        RunError: the solver of linear programmes found no solution.
    """
    scenario = load_scenario(scenario)
    check(scenario)
    devices.configure()
    names = [motion.name for motion in scenario.motions] or [scenario.name]
    each = zip(names, scenario.each_motion(), strict=True)
    return {name: _of_motion(name, where) for name, where in each}


def _of_motion(name: str, scenario: Scenario) -> Attainable:
    played = rollout_of(scenario)
    start = CAxisState(*(float(x) for x in played.samples.start[0]))
    machine = linear_model(scenario.plant.each()[0].parameters)
    one = sampled(machine, scenario.simulation.sample_time_s)
    moved = undriven(machine, played.samples, played.substeps, start)
    errors = np.asarray(played.samples.axes[0].target) - moved[:, ANGLE]
    if len(errors) == 1:  # no voltage can change this error
        first = abs(float(errors[0]))
        return Attainable(name, first, first, first, 1, 0.0, np.zeros(1))
    largest = np.full(len(errors), played.limit)
    largest[: int(scenario.limits.of(scenario.plant.machine.axes[0]).delay_samples)] = 0.0
    count = min(SAMPLES + int(np.argmax(np.abs(errors) > 0.0)), len(errors))
    while True:
        case = _case(machine, one, moved, played, largest, start, count)
        solution, proof, late = _bound(case)
        if count >= min(MOST_SAMPLES, len(errors)) or late <= LATE:
            break
        count = min(2 * count, len(errors))
    known = best_voltage(played, np.append(solution.inputs[:, 0], 0.0), largest)
    total, first = float(np.abs(known.error).sum()), abs(float(errors[0]))
    best = _tightened(case._replace(budget=total - first), proof, known)
    return Attainable(
        name=name,
        bound=min(first + max(best.bound, 0.0), total),
        simple=first + max(proof.bound, 0.0),
        reached=total,
        samples=count,
        allowance=best.rounding + best.between,
        voltage=known.voltage,
    )


def _case(
    machine: LinearModel,
    one: Sampled,
    moved: Floats,
    played: Rollout,
    largest: Floats,
    start: CAxisState,
    count: int,
) -> Case:
    """Return the motions of the first ``count`` samples."""
    target = np.asarray(played.samples.axes[0].target)[1:count]
    loads = np.asarray(played.samples.axes[0].loads)[:, :count]
    z = start.bristle_deflection
    reached = reachable(machine, one, moved[:count], loads, largest[: count - 1], abs(z))
    bounds = Bounds(largest[: count - 1], -reached.bristles, reached.bristles)
    errors = target - moved[1:count, ANGLE]
    return Case(machine, one, moved[:count], errors, reached, bounds, np.inf, z)


def _programme(case: Case) -> LinearProgram:
    steps, one, bounds = len(case.errors), case.one, case.bounds
    driven = np.column_stack([one.voltage, one.bristle])
    system = Linear(np.repeat(one.a[None], steps, 0), np.repeat(driven[None], steps, 0), ANGLE)
    low, high = [-bounds.voltage, bounds.low], [bounds.voltage, bounds.high]
    return linear_program(system, case.errors, np.column_stack(low), np.column_stack(high))


def _bound(case: Case) -> tuple[Solved, Certified, float]:
    """Return the solution, its certified bound, and the share of the last quarter in its errors."""
    solution = _programme(case).least_sum()
    if solution is None:
        raise RunError("the linear programme of the bound has no solution that HiGHS finds")
    multipliers = np.clip(solution.multipliers, -1.0, 1.0)
    proof = certified(case.machine, case.one, case.errors, multipliers, case.bounds)
    left = np.abs(solution.errors)
    late = float(left[-(len(left) // 4) :].sum() / max(left.sum(), np.finfo(float).tiny))
    return solution, proof, late


def _tightened(case: Case, proof: Certified, known: RolledOut) -> Certified:
    """Return a bound for motions that are better than the ``known`` one, by bounds of friction.

    The solver may fail in any round; the bounds of the previous rounds remain valid.
    """
    added = np.abs(known.error[1 : len(case.errors) + 1]).cumsum()
    end = min(int(np.searchsorted(added, MOSTLY * case.budget)) + 1, len(case.errors))
    steps = [*range(2, end, max(end // ASKED, 1)), end]
    signs = np.sign(known.states[steps, CAxisState._fields.index("spindle_velocity")])
    for _ in range(ROUNDS):
        part = case.first(min(end + AFTER, len(case.errors)))
        low, high = speeds(part, _programme(part), steps, signs)
        rest = case.reachable.speed[len(low) :]
        low, high = np.append(low, -rest), np.append(high, rest)
        case = case._replace(bounds=bent(case, low, high))
        better = _bound(case)[1]
        rise = better.bound - proof.bound
        proof = better if rise > 0.0 else proof
        if rise <= RISE * abs(proof.bound) or proof.bound >= case.budget:
            break
    return proof
