"""The logs that ``identify`` is given: what they are called, their columns, their signals."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from hfc_design.core.records import UserError
from hfc_design.core.texts import about
from hfc_design.files.scenario import Scenario
from hfc_design.identify.recording import Recording, recording
from hfc_design.logs.columns import Column, asked
from hfc_design.logs.reading import read_log
from hfc_design.logs.signals import signals
from plants import Drive

#: Where the system shows what is piped into a program.
PIPES = "/dev/", "/proc/"


def called(log: Path) -> str:
    """What a log is called: the end of a pipe has no name of its own, a file behind it has."""
    if not os.path.abspath(log).startswith(PIPES):
        return log.name
    behind = Path(os.path.realpath(log))
    return behind.name if behind.is_file() else "log"


class Source(NamedTuple):
    """A log that is not read yet."""

    path: Path
    columns: list[Column]


def sources(
    log: Path, drive: Drive, columns: Sequence[str], others: Sequence[str], check_log: Path | None
) -> dict[str, Source]:
    """The logs by their names, with what the user says of their columns.

    Raises:
        UserError: that cannot be understood, or is not of the ``drive``.
    """
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
    logs: dict[str, Source], base: Scenario, drive: Drive, sample_time: float | None
) -> tuple[dict[str, Recording], Scenario]:
    """What is recorded, and the scenario in the cycle and the substeps that the logs need.

    Raises:
        UserError: one cannot be read or has not what is needed; the line says which and why.
    """
    found = {name: _recording(one, drive, sample_time) for name, one in logs.items()}
    return found, _in_cycle(base, drive, next(iter(found.values())), found)


def _recording(one: Source, drive: Drive, sample_time: float | None) -> Recording:
    read = read_log(one.path)
    with about(one.path):
        return recording(signals(read, drive, one.columns, sample_time), drive)


def _in_cycle(
    scenario: Scenario, drive: Drive, told: Recording, logs: dict[str, Recording]
) -> Scenario:
    """The scenario with the logs' sample time, and substeps that their speeds need."""
    every = told.sample_time
    for name, other in logs.items():
        if abs(other.sample_time / every - 1.0) > 1e-3:
            raise UserError(f"{name}: is sampled every {other.sample_time:g} s, not {every:g} s")
    speed = max(_speed(one) for one in logs.values())
    axis = scenario.plant.each()[scenario.machine.drives.index(drive)]
    substeps = scenario.simulation.substeps
    while drive.fastest(axis.parameters, every / substeps) < speed and substeps < 1000:
        substeps *= 2
    changes = {"sample_time_s": every, "substeps": substeps}
    simulation = scenario.simulation.model_copy(update=changes)
    return scenario.model_copy(update={"simulation": simulation})


def _speed(told: Recording) -> float:
    """Largest speed over ten samples: noise is none."""
    place = told.place
    return float(abs(place[10:] - place[:-10]).max() / (10 * told.sample_time))
