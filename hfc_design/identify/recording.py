"""Recorded motions of one axis, in units of its drive."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import SAME, Floats
from hfc_design.core.records import UserError, option
from hfc_design.core.texts import as_user_error
from hfc_design.identify.request import Task
from hfc_design.logs.columns import Column, parse_columns, rates_of
from hfc_design.logs.reading import read_log
from hfc_design.logs.signals import EvenLog, signals
from plants import Drive

#: The velocity at the start is the slope of a cubic through so many samples; it counts as 0 if it
#: is below so many standard errors.
BEGINNING, CLEAR = 20, 4.0
#: Folders of the system in which pipes into a program have their names.
PIPES = "/dev/", "/proc/"


class Source(NamedTuple):
    """A log that has not been read yet."""

    path: Path
    columns: list[Column]


class Recording(NamedTuple):
    """Recorded signals of one axis, arrays (steps,) in units of its drive."""

    outputs: dict[str, Floats]  # measured signals; the first is the position that is fed back
    command: Floats | None  # None: not recorded
    reference: Floats | None  # None: not recorded
    load: Floats
    added: Floats  # signal added to the command of the controller; the recorded command has it
    usable: Floats  # 1 where the outputs count, else 0
    sample_time: float  # [s]
    rate: float  # velocity at the start [unit of the position per s]
    notes: tuple[str, ...] = ()
    step: float | None = None  # of the position's encoder, if the log shows it

    @property
    def place(self) -> Floats:
        """The position that is fed back."""
        return next(iter(self.outputs.values()))

    @property
    def duration(self) -> float:
        """Duration of the recording [s]."""
        return self.sample_time * len(self.load)


def recording(log: EvenLog, drive: Drive) -> Recording:
    """Return the recording of a ``drive`` from its evenly sampled signals."""
    position, values = drive.seen[0], log.values
    place = values[position]
    time = log.sample_time * np.arange(len(place[:BEGINNING]))
    (*_, rate, _), errors = np.polyfit(time, place[:BEGINNING], 3, cov=True)
    noise = max(CLEAR * np.sqrt(errors[2, 2]), SAME * np.ptp(place) / time[-1])
    if abs(rate) < noise:  # it begins at rest
        rate = 0.0
    shown = drive.signals(drive.coefficients(drive.parameters()), drive.initial_state(0.0))
    rates, still = rates_of(drive), np.zeros_like(place)
    measured = dict.fromkeys([position, *rates, *rates.values(), *shown])
    return Recording(
        outputs={name: values[name] for name in measured if name in values},
        command=values.get("command"),
        reference=values.get("reference"),
        load=values.get("load", still),
        added=values.get("added", still),
        usable=log.usable.astype(float),
        sample_time=log.sample_time,
        rate=float(rate),
        notes=tuple(log.notes),
        step=log.step,
    )


def log_name(log: Path) -> str:
    """Return the file name of a log; for a pipe that of the file behind it, or "log"."""
    if not os.path.abspath(log).startswith(PIPES):
        return log.name
    behind = Path(os.path.realpath(log))
    return behind.name if behind.is_file() else "log"


def sources(
    task: Task, log: Path, columns: Sequence[str], check_log: Path | None, others: Sequence[str]
) -> dict[str, Source]:
    """Return the logs by name; for ``check_log``, ``others`` override assignments in ``columns``.

    Raises:
        UserError: an assignment of columns is not valid, or does not fit the drive.
    """
    drive = task.drive_axis.drive
    if others and check_log is None:
        given = option("check_column", argument="check_columns")
        raise UserError(f"{given}: needs {option('check_log', ...)}")
    with as_user_error(log):
        logs = {log_name(log): Source(log, parse_columns(columns, drive))}
    if check_log is not None:
        with as_user_error(check_log):
            both = {x.name: x for some in (columns, others) for x in parse_columns(some, drive)}
        name = log_name(check_log)
        name = name if name not in logs else f"{name} (check)"
        logs[name] = Source(check_log, [*both.values()])
    return logs


def recordings(
    task: Task, logs: dict[str, Source], sample_time: float | None
) -> tuple[Task, dict[str, Recording]]:
    """Return the task with the sample time and substeps that the logs need, and the recordings.

    Raises:
        UserError: a log cannot be read, lacks a signal, or has another sample time than the first.
    """
    recorded, axis, simulation = dict[str, Recording](), task.drive_axis, task.scenario.simulation
    for name, source in logs.items():
        columns = read_log(source.path)
        # The first log may be the one of an experiment; others need no signal added to the command.
        lacks = {"added"} if recorded else set[str]()
        chosen = [x for x in source.columns if x.column in columns.columns or x.name not in lacks]
        with as_user_error(source.path):
            even = signals(columns, axis.drive, chosen, sample_time)
            recorded[name] = recording(even, axis.drive)
    every = next(iter(recorded.values())).sample_time
    for name, log in recorded.items():
        if abs(log.sample_time / every - 1.0) > 1e-3:
            got = f"(got {log.sample_time:g} s)"
            raise UserError(f"{name}: must be sampled every {every:g} s {got}")
    # The largest mean speed over ten samples, in which noise hardly counts.
    moves = (abs(log.place[10:] - log.place[:-10]).max() for log in recorded.values())
    speed, substeps = float(max(moves)) / (10 * every), simulation.substeps
    while axis.drive.fastest(axis.parameters, every / substeps) < speed and substeps < 1000:
        substeps *= 2
    simulation = simulation.model_copy(update={"sample_time_s": every, "substeps": substeps})
    scenario = task.scenario.model_copy(update={"simulation": simulation})
    return task._replace(scenario=scenario), recorded
