"""The logs of EMPS and scenarios that follow them; of the data nothing is kept here.

The folder that the environment variable EMPS_DATA names holds DATA_EMPS.mat and
DATA_EMPS_PULSES.mat (A. Janot, M. Gautier, M. Brunot, "Data set and reference models of EMPS",
Nonlinear System Identification Benchmarks, 2019).
"""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import click
import numpy as np
from numpy.typing import NDArray
from scipy.io import loadmat

from hfc_design.core.numbers import Json
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.scenario import Scenario

Floats = NDArray[np.float64]
DATA = "EMPS_DATA"
FILES = {"first": "DATA_EMPS.mat", "second": "DATA_EMPS_PULSES.mat"}
SAMPLE = 1e-3  # [s]
GAIN = 35.1507  # published, of the amplifier with its motor and screw [N/V]
#: Of the loop that recorded them: of the position [V/mm], of the velocity [V s/mm].
K_P, K_V = 0.16018 * 243.45, 0.24345
#: The velocity is the difference of readings that are so many samples apart.
APART = 2
SENSORS: Json = {"velocity": "encoder", "difference_samples": APART, "encoder_resolution": 5e-5}


class Log(NamedTuple):
    """A log in mm and V; every array (steps,), the reference with what came before."""

    reference: Floats
    earlier: int  # samples of the reference before the log begins
    position: Floats
    command: Floats
    pushed: Floats  # 1 where a voltage was added to the command, else 0

    @property
    def pulse(self) -> float:
        """The voltage that was added, by what the controller cannot have commanded [V]."""
        law = K_P * (self.reference[self.earlier :] - self.position)
        law[APART:] -= K_V * (self.position[APART:] - self.position[:-APART]) / (APART * SAMPLE)
        more, push = (self.command - law)[APART:], self.pushed[APART:]
        return float(more[push > 0].mean()) if push.any() else 0.0

    def until(self, seconds: float) -> "Log":
        """Its beginning alone."""
        count = round(seconds / SAMPLE)
        whole = self.reference[: self.earlier + count]
        return Log(whole, self.earlier, *(column[:count] for column in self[2:]))


def folder() -> Path:
    """Where the data lie; UsageError: nobody says, or they do not."""
    named = os.environ.get(DATA)
    if not named:
        raise click.UsageError(f"{DATA} names no folder with {', '.join(FILES.values())}")
    return Path(named)


def log(which: str) -> Log:
    """The first or the second one.

    It begins in the motion, which the reference tells: it rises as from rest at 0 under the
    acceleration of its first samples, so that much is put before it.
    """
    file = folder() / FILES[which]
    try:
        found = {key: np.ravel(x) for key, x in loadmat(file).items() if key[0] != "_"}
    except (OSError, ValueError) as error:
        raise click.UsageError(f"{file}: {error}") from None
    reference = 1e3 * found["qg"]
    rise = float(np.diff(reference[:4], 2).mean())
    earlier = round(float(np.sqrt(2.0 * reference[0] / rise)))
    before = reference[0] * (np.arange(earlier) / earlier) ** 2
    pushed = np.sign(found.get("pulses_N", np.zeros(len(reference))))
    place = 1e3 * found["qm"]
    return Log(np.append(before, reference), earlier, place, found["vir"], pushed)


def following(
    one: Log, place: Path, parameters: Mapping[str, float], pulse: float = 0.0, **changes: Json
) -> Scenario:
    """A scenario that follows the reference of a log, with its sensors and its limit.

    Args:
        one: the log.
        place: a folder for the tables that the scenario reads.
        parameters: of the stage, where they are not those of EMPS.
        pulse: added to the command where the log has a pulse [V]: as a load that it would need.
        changes: tables of the scenario that replace these.
    """
    time = SAMPLE * np.arange(len(one.reference))
    np.savetxt(place / "reference.csv", np.c_[time, one.reference], "%.12g", ",")
    pushed = np.append(np.full(one.earlier, one.pushed[0]), one.pushed)
    jumps = np.flatnonzero(np.diff(pushed)) + 1
    corners = np.sort(np.concatenate([[0.0], SAMPLE * jumps - 1e-9, SAMPLE * jumps, [time[-1]]]))
    held = pushed[np.floor(corners / SAMPLE + 1e-7).astype(int)]
    np.savetxt(place / "load.csv", np.c_[corners, -pulse * GAIN * held], "%.12g", ",")
    reference = {"kind": "csv", "file": str(place / "reference.csv"), "interpolation": "cubic"}
    return load_scenario(
        {
            "name": "recorded",
            "plant": {"name": "positioning-stage", "parameters": dict(parameters)},
            "reference": reference,
            "load": {"file": str(place / "load.csv")},
            "simulation": {"duration_s": len(time) * SAMPLE, "sample_time_s": SAMPLE},
            "sensors": SENSORS,
            "limits": {"command": 10.0},
            "fitness": {"kind": "tolerances"},
            "controller": {"kind": "pid+ff"},
            **changes,
        }
    )
