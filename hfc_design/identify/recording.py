"""Motions of one axis that were recorded, in units of its drive."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import SAME, Floats
from hfc_design.core.records import UserError
from hfc_design.core.texts import about
from hfc_design.identify.request import Task
from hfc_design.logs.columns import Column, asked, rates_of
from hfc_design.logs.reading import read_log
from hfc_design.logs.signals import Even, signals
from plants import Drive

#: The velocity at the start is that of a cubic through so many samples.
BEGINNING = 20
#: In so many standard errors.
CLEAR = 4.0
#: Where the system shows what is piped into a program.
PIPES = "/dev/", "/proc/"


class Source(NamedTuple):
    """A log that is not read yet."""

    path: Path
    columns: list[Column]


class Recording(NamedTuple):
    """One axis, (steps,) each, in units of its drive."""

    outputs: dict[str, Floats]  # what was measured; the first is the position that is fed back
    command: Floats | None  # None: not recorded
    reference: Floats | None
    load: Floats
    added: Floats  # to the command of the controller, and within the recorded one
    usable: Floats  # 1 where the outputs count, else 0
    sample_time: float  # [s]
    rate: float  # of the position at the start
    notes: tuple[str, ...] = ()
    step: float | None = None  # of the encoder of the position, where it is seen

    @property
    def place(self) -> Floats:
        """The position that is fed back."""
        return next(iter(self.outputs.values()))

    @property
    def duration(self) -> float:
        """How long it lasts [s]."""
        return self.sample_time * len(self.load)


def recording(found: Even, drive: Drive) -> Recording:
    """What is replayed of the signals of a ``drive``: its position, and what else was measured."""
    seen = drive.seen[0]
    place = found.values[seen]
    time = found.sample_time * np.arange(len(place[:BEGINNING]))
    (*_, rate, _), errors = np.polyfit(time, place[:BEGINNING], 3, cov=True)
    noise = max(CLEAR * np.sqrt(errors[2, 2]), SAME * np.ptp(place) / time[-1])
    if abs(rate) < noise:  # it begins at rest
        rate = 0.0
    shown = drive.signals(drive.coefficients(drive.parameters()), drive.initial_state(0.0))
    rates = rates_of(drive)
    measured = dict.fromkeys([seen, *rates, *rates.values(), *shown])
    return Recording(
        {name: found.values[name] for name in measured if name in found.values},
        found.values.get("command"),
        found.values.get("reference"),
        found.values.get("load", np.zeros_like(place)),
        found.values.get("added", np.zeros_like(place)),
        found.usable.astype(float),
        found.sample_time,
        float(rate),
        tuple(found.notes),
        found.step,
    )


def called(log: Path) -> str:
    """What a log is called: the end of a pipe has no name of its own, a file behind it has."""
    if not os.path.abspath(log).startswith(PIPES):
        return log.name
    behind = Path(os.path.realpath(log))
    return behind.name if behind.is_file() else "log"


def sources(
    task: Task, log: Path, columns: Sequence[str], check_log: Path | None, others: Sequence[str]
) -> dict[str, Source]:
    """The logs by their names, with what the user says of their columns.

    Raises:
        UserError: that cannot be understood, or is not of the drive.
    """
    drive = task.one.drive
    if others and check_log is None:
        raise UserError("--check-column: needs --check-log")
    with about(log):
        found = {called(log): Source(log, asked(columns, drive))}
    if check_log is not None:
        name = called(check_log)
        with about(check_log):
            both = {one.name: one for one in (*asked(columns, drive), *asked(others, drive))}
        own = Source(check_log, [*both.values()])
        found[name if name not in found else f"{name} (check)"] = own
    return found


def recordings(
    task: Task, logs: dict[str, Source], sample_time: float | None
) -> tuple[Task, dict[str, Recording]]:
    """The task in the cycle and the substeps that the logs need, and what is recorded.

    Raises:
        UserError: one cannot be read or has not what is needed; the line says which and why.
    """
    found, scenario = dict[str, Recording](), task.scenario
    axis = task.one
    for name, source in logs.items():
        read = read_log(source.path)
        with about(source.path):
            seen = signals(read, axis.drive, source.columns, sample_time)
            found[name] = recording(seen, axis.drive)
    every = next(iter(found.values())).sample_time
    for name, one in found.items():
        if abs(one.sample_time / every - 1.0) > 1e-3:
            raise UserError(f"{name}: is sampled every {one.sample_time:g} s, not {every:g} s")
    # The largest speed over ten samples: noise is none.
    each = (abs(one.place[10:] - one.place[:-10]).max() for one in found.values())
    speed, substeps = float(max(each)) / (10 * every), scenario.simulation.substeps
    while axis.drive.fastest(axis.parameters, every / substeps) < speed and substeps < 1000:
        substeps *= 2
    changes = {"sample_time_s": every, "substeps": substeps}
    simulation = scenario.simulation.model_copy(update=changes)
    scenario = scenario.model_copy(update={"simulation": simulation})
    return task._replace(scenario=scenario), found
