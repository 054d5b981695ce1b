"""A machine and its log -> what the log tells of the machine, checked on a second log."""

import numpy as np

from hfc_design.core.plugins import own_code
from hfc_design.core.records import UserError
from hfc_design.core.texts import about
from hfc_design.identify.advice import advice, profiles
from hfc_design.identify.asking import Source, Task, looked_for
from hfc_design.identify.certainty import certainty
from hfc_design.identify.checks import checked, doubts, strangers
from hfc_design.identify.fit import Fit
from hfc_design.identify.free import LATE, Free
from hfc_design.identify.kept import fault, halved, kept
from hfc_design.identify.loop import loop
from hfc_design.identify.recording import Recording, recordings
from hfc_design.identify.response import response
from hfc_design.identify.result import Identified, response_lines
from hfc_design.identify.search import Found, Tell, bandwidths, by_command, by_loop


def answered(
    task: Task, logs: dict[str, Source], sample_time: float | None, tell: Tell
) -> Identified:
    """What logs that are not read yet tell; ``sample_time`` [s] is for those that do not say it.

    Raises:
        UserError: one cannot be read, has not what is needed, or no replay of it stays finite.
    """
    drive = task.scenario.machine.drives[task.axis]
    read, scenario = recordings(logs, task.scenario, drive, sample_time)
    return identify(task._replace(scenario=scenario), read, tell)


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
    found, known, states, note = kept(found, known)
    own, (known, apart) = response(found), halved(found, known, states)
    if fault_found := fault(found.fit.free, found.fit.numbers):
        told_why = f"is only replayed with what no machine has: {fault_found}"
        raise UserError(f"{name}: {told_why}; look for fewer with --free")
    checks = checked(task.scenario, task.design, found, logs)
    pushed = task.scenario.machine.forces is not None
    against = *doubts(name, found, known, told, pushed), *strangers(checks, logs)
    said = (note, apart, *response_lines(own), *against, *told.notes, wanted.rest())
    parts = found, known, states, worst, checks, next_one, own, told
    return Identified(name, task, *parts, tuple(filter(None, said)))


def _found(task: Task, wanted: Free, name: str, told: Recording, tell: Tell) -> Found:
    if told.command is not None:
        with about(name):
            tried = bandwidths(told, task.bandwidth)
    for line in filter(None, [wanted.wanted(), wanted.rest()]):
        tell(line)
    if told.command is not None:
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
        bad = [(*fit.free.names, *LATE)[k] for k in lost]
        raise ValueError(
            f"its replay has no slope by {', '.join(bad)}: look for others with --free, or mend "
            "the plant's step there"
        )
