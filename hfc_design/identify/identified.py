"""A machine and its log -> what the log tells of the machine, checked on a second log."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hfc_design.core.plugins import own_code
from hfc_design.core.records import UserError
from hfc_design.core.texts import about
from hfc_design.files.design import Design
from hfc_design.files.scenario import Scenario
from hfc_design.identify.advice import Advice, advice
from hfc_design.identify.bounds import fault
from hfc_design.identify.certainty import Certainty, certainty
from hfc_design.identify.checks import Check, checked, doubts, how_of, strangers
from hfc_design.identify.fit import Fit
from hfc_design.identify.free import Free, free
from hfc_design.identify.kept import kept
from hfc_design.identify.loop import loop
from hfc_design.identify.profile import Profile, profiles
from hfc_design.identify.recording import Recording
from hfc_design.identify.search import Found, Tell, bandwidths, by_command, by_loop


class Task(NamedTuple):
    """What is to be identified, and how."""

    scenario: Scenario  # its plant with the values to start from, sensors, limits
    axis: int  # which one
    design: Design | None  # the controller in the loop that recorded the logs
    names: Sequence[str] | None  # parameters that are looked for; None: all that may be
    bandwidth: float | None  # of the observer [Hz]; 0: open loop; None: that of the least residual
    seed: int = 0


class Identified(NamedTuple):
    """Everything that a log tells."""

    scenario: Scenario
    axis: int
    found: Found
    known: Certainty
    states: tuple[str, ...]  # of each parameter, see ``Kept``
    profiles: tuple[Profile, ...]
    checks: tuple[Check, ...]
    advice: Advice | None
    told: Recording
    notes: tuple[str, ...]

    @property
    def free(self) -> Free:
        """The parameters that were looked for."""
        return self.found.fit.free

    @property
    def how(self) -> str:
        """How the log was replayed."""
        return how_of(self.found)

    @property
    def position_unit(self) -> str:
        """Of the residual."""
        return self.free.drive.units["error"]


def looked_for(task: Task) -> Free:
    """The parameters that are looked for.

    Raises:
        UserError: one is unknown, or has no value to start from.
    """
    start = task.scenario.plant.each()[task.axis]
    changes = start.parameters._asdict()
    nominal = start.drive.parameters()._asdict()
    own = {key: value for key, value in changes.items() if value != nominal[key]}
    try:
        return free(start.drive, own, task.names)
    except ValueError as error:
        raise UserError(f"--free {error}") from None


def identify(task: Task, logs: dict[str, Recording], tell: Tell = lambda line: None) -> Identified:
    """What the first of ``logs`` tells of the machine of ``task``; the others check it.

    Raises:
        UserError: a parameter is unknown, there is nothing to replay a log with, or no replay
            of it stays finite.
    """
    (name, told), *_ = logs.items()
    wanted = looked_for(task)
    for log, each in logs.items():
        if each.command is None and (task.design is None or each.reference is None):
            why = "has no command; with the reference and --controller DESIGN its loop is replayed"
            raise UserError(f"{log}: {why}")
    own_parts = [("plant", wanted.drive.name), ("plant", task.scenario.plant.name)]
    with own_code(" cannot be replayed", *own_parts):
        found = _found(task, wanted, name, told, tell)
    with about(name):
        _check_slopes(found.fit)
    substeps = task.scenario.simulation.substeps
    known = certainty(found.fit)
    tell("how the fit grows worse beside the best values")
    worst = profiles(found, known)
    tell("what to record next")
    next_one = advice(found, known, told, substeps)
    tell("what the parameters do on each log")
    found, known, states, note = kept(found, known, told.command is not None)
    if fault_found := fault(found.fit.free, found.fit.numbers):
        told_why = f"is only replayed with what no machine has: {fault_found}"
        raise UserError(f"{name}: {told_why}; look for fewer with --free")
    checks = checked(task.scenario, task.design, found, logs)
    pushed = task.scenario.machine.forces is not None
    against = *doubts(name, found, known, told, pushed), *strangers(checks, logs)
    notes = (*filter(None, [note]), *against, *told.notes, *filter(None, [wanted.rest()]))
    return Identified(
        task.scenario, task.axis, found, known, states, worst, checks, next_one, told, notes
    )


def _found(task: Task, wanted: Free, name: str, told: Recording, tell: Tell) -> Found:
    if told.command is not None:
        with about(name):
            tried = bandwidths(told, task.bandwidth)
        substeps = task.scenario.simulation.substeps
        return by_command(wanted, told, substeps, tried, task.seed, tell)
    assert task.design is not None
    return by_loop(wanted, told, loop(task.scenario, task.design, told), task.seed, tell)


def _check_slopes(fit: Fit) -> None:
    """ValueError: what was found tells nothing, for it is not finite."""
    if not np.isfinite(fit.rms).all():
        raise ValueError("no parameters were found with which a replay stays finite")
    lost = np.flatnonzero(~np.isfinite(fit.jacobian).all(axis=(0, 1)))
    if lost.size:
        bad = [(*fit.free.names, "delay")[k] for k in lost]
        raise ValueError(
            f"its replay has no slope by {', '.join(bad)}: look for others with --free, or mend "
            "the plant's step there"
        )
