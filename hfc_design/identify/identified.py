"""A machine and its log -> what the log tells of the machine, checked on a second log."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import jax
import numpy as np

from hfc_design.core.numbers import Floats
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.files.scenario import Scenario
from hfc_design.identify.advice import Advice, advice
from hfc_design.identify.certainty import Certainty, certainty
from hfc_design.identify.fit import Fit, offs
from hfc_design.identify.free import Free, free
from hfc_design.identify.kept import kept
from hfc_design.identify.loop import loop
from hfc_design.identify.profile import Profile, profiles
from hfc_design.identify.recording import Recording
from hfc_design.identify.replay import Residual, replay
from hfc_design.identify.search import Found, by_command, by_loop

#: A residual above this share of the motion is no replay of it.
LOST = 0.2


class Task(NamedTuple):
    """What is to be identified, and how."""

    scenario: Scenario  # its plant with the values to start from, sensors, limits
    axis: int  # which one
    design: Design | None  # the controller in the loop that recorded the logs
    names: Sequence[str] | None  # parameters that are looked for; None: all that may be
    bandwidth: float | None  # of the observer [Hz]; 0: open loop; None: that of the least residual
    seed: int = 0


class Check(NamedTuple):
    """A log replayed with the parameters that were found, or with those of the start."""

    log: str
    how: str  # under the recorded command, or in closed loop
    before: float  # rms residual with the parameters of the start [unit of the position]
    after: float
    residual: Floats  # (steps,) recorded less simulated


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


def identify(
    task: Task, logs: dict[str, Recording], tell: Callable[[str], None] = lambda line: None
) -> Identified:
    """What the first of ``logs`` tells of the machine of ``task``; the others check it.

    Raises:
        UserError: a parameter is unknown, or there is nothing to replay the log with.
    """
    (name, told), *_ = logs.items()
    start = task.scenario.plant.each()[task.axis]
    changes = start.parameters._asdict()
    nominal = start.drive.parameters()._asdict()
    own = {key: value for key, value in changes.items() if value != nominal[key]}
    try:
        wanted = free(start.drive, own, task.names)
    except ValueError as error:
        raise UserError(f"--free {error}") from None
    substeps = task.scenario.simulation.substeps
    if told.command is not None:
        found = by_command(wanted, told, substeps, task.bandwidth, task.seed, tell)
    elif task.design is not None and told.reference is not None:
        found = by_loop(wanted, told, loop(task.scenario, task.design, told), task.seed, tell)
    else:
        why = "has no command; with the reference and --controller DESIGN its loop is replayed"
        raise UserError(f"{name}: {why}")
    if not np.isfinite(found.fit.rms).all():
        raise UserError(f"{name}: no parameters were found with which a replay stays finite")
    known = certainty(found.fit)
    tell("how the fit grows worse beside the best values")
    worst = profiles(found, known)
    tell("what to record next")
    next_one = advice(found, known, told, substeps)
    tell("what the parameters do on each log")
    found, known, states, note = kept(found, known, told.command is not None)
    checks = tuple(_checks(task, found, logs))
    notes = (*filter(None, [note]), *_doubts(name, found, known, told), *told.notes)
    return Identified(
        task.scenario, task.axis, found, known, states, worst, checks, next_one, told, notes
    )


def _checks(task: Task, found: Found, logs: dict[str, Recording]) -> list[Check]:
    checks = []
    for name, told in logs.items():
        ways: dict[str, Residual] = {}
        if told.command is not None and found.bandwidth is not None:
            own = replay(found.fit.free, told, found.bandwidth, task.scenario.simulation.substeps)
            ways[how_of(found)] = own
        if task.design is not None and told.reference is not None:
            ways["closed loop"] = loop(task.scenario, task.design, told)
        for how, residual in ways.items():
            first, last = (
                _off(found, residual, x) for x in (found.fit.free.begun, found.fit.numbers)
            )
            checks.append(Check(name, how, _rms(first), _rms(last), last))
    return checks


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _off(found: Found, residual: Residual, numbers: Floats) -> Floats:
    """(steps,) of the position."""
    problem = found.problem._replace(residual=residual)
    with jax.enable_x64(True):
        return np.asarray(offs(problem, numbers))[:, 0]


def how_of(found: Found) -> str:
    """In words."""
    if found.bandwidth is None:
        return "closed loop"
    if not found.bandwidth:
        return "recorded command, open loop"
    return f"recorded command, observer of {found.bandwidth:g} Hz"


def _doubts(name: str, found: Found, known: Certainty, told: Recording) -> list[str]:
    """What a user has to know before he uses the parameters."""
    fit, notes = found.fit, []
    share = float(fit.rms[0] / max(np.std(told.place), 1e-300))
    if share > LOST:
        notes.append(
            f"NOT USABLE: the best replay is {100 * share:.3g} % of the motion off (rms); is it "
            "this machine, and are the columns and units right?"
        )
    for parameter, factor in fit.free.away(fit.numbers).items():
        if dict(zip(fit.free.names, known.told, strict=True))[parameter]:
            notes.append(
                f"DOUBTFUL: {name} is only replayed with {factor:.3g} times the {parameter} that "
                "it began with; are the units of its columns right, mm or m, say?"
            )
    if fit.free.drive.fault(_changed(fit)) is not None:
        notes.append(f"DOUBTFUL: {fit.free.drive.fault(_changed(fit))}")
    low, high = known.late
    if low > 0.0 or high < 0.0:
        ms, word = 1e3 * abs(fit.late) * told.sample_time, "later" if fit.late > 0 else "earlier"
        notes.append(
            f"the command acts {ms:.2g} ms {word} than its samples say ({fit.late:+.2f} samples)"
        )
    return notes


def _changed(fit: Fit) -> dict[str, float]:
    return dict(zip(fit.free.names, map(float, fit.free.values(fit.numbers)), strict=True))
