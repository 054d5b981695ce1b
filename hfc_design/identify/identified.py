"""Identification of a machine from its logs: the result, and what makes it doubtful."""

from collections.abc import Iterator, Sequence

import numpy as np

from hfc_design.core.numbers import Floats, rms
from hfc_design.core.plugins import own_code
from hfc_design.core.records import UserError, either, option
from hfc_design.core.texts import as_user_error, toml_of
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.scenario import Scenario
from hfc_design.identify.fit import Fit, Tell, bandwidths, by_command, by_starts, residuals, silent
from hfc_design.identify.identifiability import (
    Certainty,
    certainty,
    fault,
    hold_untold,
    unseen_backlash,
    widened_by_halves,
)
from hfc_design.identify.outcome import Check, Outcome
from hfc_design.identify.parameters import LATE, FreeParameters
from hfc_design.identify.profiles import profiles
from hfc_design.identify.recording import Recording
from hfc_design.identify.replay import Residual, closed_loop_residual, replay
from hfc_design.identify.request import Task, parameters_of
from hfc_design.identify.response import response
from hfc_design.identify.scenario import scenario_text

#: Residual (rms) as a share of the motion (standard deviation) above which the result is useless.
LOST = 0.2
#: A log with a residual of more than so many times that of the first may be of another machine.
STRANGE = 4.0
#: Share of the commands beyond the limits of the drive above which the model is useless.
CLIPPED = 0.1
#: A log may list a command up to so many samples after it acts; more is an error of the model.
SHIFTED = 2.0


class Identified(Outcome):
    """Result of an identification, as a script receives it."""

    def for_design(self) -> Scenario:
        """Return the scenario for a search: the identified machine with its tolerances.

        Raises:
            UserError: the parameters do not give a valid scenario.
        """
        return load_scenario(toml_of(scenario_text(self)))


def identify(task: Task, logs: dict[str, Recording], tell: Tell = silent) -> Identified:
    """Identify the machine of ``task`` from the first of ``logs``; the other logs check the result.

    Raises:
        UserError: a parameter is unknown, a log lacks a signal or is too short for an observer, no
            replay of the first log stays finite, or only impossible parameters fit it.
    """
    (name, log), *_ = logs.items()
    wanted, substeps = parameters_of(task), task.scenario.simulation.substeps
    for other, recorded in logs.items():
        if recorded.command is None and (task.design is None or recorded.reference is None):
            design = either("--controller DESIGN", "controller=DESIGN")
            why = f"has no command; to replay its loop give the reference and {design}"
            raise UserError(f"{other}: {why}")
    own_parts = [("plant", wanted.drive.name), ("plant", task.scenario.plant.name)]
    with own_code(" cannot be replayed", *own_parts):
        fit = _fit(task, wanted, name, log, tell)
    with as_user_error(name):
        check_slopes(fit)
    known = certainty(fit)
    tell("likelihood profiles")
    worst = profiles(fit, known)
    tell("fitted again without the parameters that the log does not determine")
    fit, known, note = hold_untold(fit, known)
    tell("parameters tested on each log")
    answer = response(fit)
    known, apart = widened_by_halves(fit, known)
    known, hidden = unseen_backlash(fit, known, log, substeps)
    if fault_found := fault(fit.free, fit.numbers):
        why = f"can be replayed only with impossible values: {fault_found}"
        raise UserError(f"{name}: {why}; identify fewer with {option('free', ...)}")
    checks = checked(task, fit, logs)
    pushed = task.scenario.machine.forces is not None
    notes = [note, apart, hidden, *(answer.lines() if answer else [])]
    notes += [*warnings_of(name, fit, known, log, pushed), *mismatched_logs(checks, logs)]
    notes = [line for line in (*notes, *log.notes, wanted.rest()) if line]
    parts = known, worst, checks, answer, log, tuple(notes)
    return Identified(name, task, fit, *parts)


def _fit(task: Task, wanted: FreeParameters, name: str, log: Recording, tell: Tell) -> Fit:
    with as_user_error(name):
        tried = [] if log.command is None else bandwidths(log, task.bandwidth)
    for line in filter(None, [wanted.wanted(), wanted.rest()]):
        tell(line)
    if tried:
        substeps = task.scenario.simulation.substeps
        return by_command(wanted, log, substeps, tried, task.seed, tell)
    assert task.design is not None
    residual = closed_loop_residual(task.scenario, task.design, log)
    return by_starts(wanted, log, residual, None, task.seed, tell)


def check_slopes(fit: Fit) -> None:
    """Check that residual and slopes of a fit are finite; ValueError: they are not."""
    if not np.isfinite(fit.rms).all():
        raise ValueError("found no parameters with which the replay stays finite")
    lost = np.flatnonzero(~np.isfinite(fit.jacobian).all(axis=(0, 1)))
    if lost.size:
        bad = [(*fit.free.names, *LATE)[k] for k in lost]
        raise ValueError(
            f"its replay is not differentiable with respect to {', '.join(bad)}: identify "
            f"others with {option('free', ...)}, or correct the plant's step there"
        )


def checked(task: Task, fit: Fit, logs: dict[str, Recording]) -> tuple[Check, ...]:
    """Return every possible replay of each log: under its command, and in closed loop."""

    def ways(log: Recording) -> Iterator[tuple[str, Residual]]:
        if log.command is not None and fit.problem.bandwidth is not None:
            substeps = task.scenario.simulation.substeps
            yield fit.how, replay(fit.free, log, fit.problem.bandwidth, substeps)
        if task.design is not None and log.reference is not None:
            yield "closed loop", closed_loop_residual(task.scenario, task.design, log)

    checks = []
    for name, log in logs.items():
        for how, residual in ways(log):
            problem = fit.problem._replace(residual=residual)
            before, after = (residuals(problem, x)[:, 0] for x in (fit.free.begun, fit.numbers))
            checks.append(Check(name, how, rms(before), rms(after), after))  # of the position
    return tuple(checks)


def warnings_of(name: str, fit: Fit, known: Certainty, log: Recording, pushed: bool) -> list[str]:
    """Return what a user must know before using the parameters, a line each.

    ``pushed``: other axes of the machine act on this axis.
    """
    notes = list[str]()
    share = float(fit.rms[0] / max(np.std(log.place), 1e-300))
    if share > LOST:
        notes.append(
            f"NOT USABLE: the best replay deviates by {100 * share:.3g} % of the motion "
            "(rms); is it this machine, and are the columns and units right?"
        )
    if log.command is not None:
        notes += saturation_warning(fit, log.command)
    if pushed:
        notes.append(
            "DOUBTFUL: the axes of this machine are coupled, and only one is replayed: "
            "the forces of the others must be in the load"
        )
    if not known.identifiable.any():
        gone, unit = float(np.ptp(log.place)), fit.free.drive.units["error"]
        notes.append(
            f"NOT USABLE: {name} determines none of the parameters: does the axis move, "
            f"and is its unit right? It moves {gone:.5g} {unit} in {log.duration:.3g} s"
        )
    for parameter, factor in fit.free.away(fit.numbers).items():
        if known.identifiable[fit.free.names.index(parameter)]:
            notes.append(
                f"DOUBTFUL: {name} needs {factor:.3g} times the start value of "
                f"{parameter}; are the units of its columns right, for example mm or m?"
            )
    low, high = known.late
    if low > 0.0 or high < 0.0:
        ms, word = 1e3 * abs(fit.late) * log.sample_time, "later" if fit.late > 0 else "earlier"
        line = f"the command acts {ms:.2g} ms {word} than its samples ({fit.late:+.2f} samples)"
        doubt = f"DOUBTFUL: {line}, which no machine does: its model may lack a mass or a mode"
        notes.append(doubt if fit.late < -SHIFTED else line)
    return notes


def saturation_warning(fit: Fit, command: Floats) -> list[str]:
    """Return a warning if recorded commands are beyond the limits of the drive, else []."""
    drive = fit.free.drive
    low, high = drive.largest_commands(fit.free.parts(fit.numbers)[0])
    share = float(np.mean((command < low) | (command > high)))
    if not share:
        return []
    why = "NOT USABLE: the model cannot reproduce its own log: " * (share > CLIPPED)
    return [
        f"{why}{100 * share:.2g} % of the commands are outside {low:.4g} to {high:.4g} "
        f"{drive.units['command']}, where the drive saturates: are that limit and the "
        "unit of the command right?"
    ]


def mismatched_logs(checks: Sequence[Check], logs: dict[str, Recording]) -> list[str]:
    """Return warnings on logs that seem not to be of the machine identified from the first log."""
    first = {check.how: check for check in checks if check.log == next(iter(logs))}
    notes = []
    for check in checks:
        mine = first.get(check.how, check)
        least = max(mine.after, 1e-9 * float(np.std(logs[check.log].place)))
        if mine is not check and not check.after <= STRANGE * least:
            times = check.after / max(mine.after, 1e-300)
            notes.append(
                f"DOUBTFUL: {check.log} is replayed {times:.3g} times worse than "
                f"{mine.log} ({check.how}): is it another machine, load or unit?"
            )
    return notes
