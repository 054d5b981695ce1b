"""What is read off the recorded motion of one axis."""

from typing import Annotated, Any

import numpy as np
from pydantic import Field

from hfc_design.core.numbers import SAME, Floats, Mask, first_at
from hfc_design.core.records import NotNegative, Positive, Record
from hfc_design.motion.samples import Simulation
from hfc_design.objectives.stick_share import is_stuck
from plants import Drive, in_a_name

#: The loop has settled once its error stays below this share of its maximum.
SETTLED = 0.1


class Window(Record):
    """A part of the motion over which every metric is read once more, a cycle for example."""

    #: stands before the names of its metrics
    name: Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]{0,31}$")]
    from_s: NotNegative = 0.0  # where it begins [s]
    to_s: Positive | None = None  # where it ends; left out: with the motion [s]

    def part(self, simulation: Simulation) -> slice:
        """Its samples."""
        time = simulation.time
        end = None if self.to_s is None else first_at(time, self.to_s)
        return slice(first_at(time, self.from_s), end)


def meanings(drive: Drive) -> dict[str, str]:
    """Name -> meaning and unit of each metric of one axis, in the order of every table."""
    error, rate, command = (drive.units[name] for name in ("error", "error_rate", "command"))
    called, squared = drive.command_name, f"{in_a_name(command)}2s"
    return {
        f"rms_error_{in_a_name(error)}": f"root mean square of the tracking error [{error}]",
        f"max_error_{in_a_name(error)}": f"largest tracking error [{error}]",
        f"iae_{in_a_name(error)}_s": f"integral of the tracking error's magnitude [{error} s]",
        f"final_error_{in_a_name(error)}": f"tracking error at the last sample [{error}]",
        "settling_time_s": "from then on the error stays below a tenth of its maximum [s]",
        f"velocity_ripple_{in_a_name(rate)}": f"rms of the velocity error once settled [{rate}]",
        "stick_share": "share of the time, once settled, below a tenth of the commanded speed [1]",
        "stick_events": "how often the axis stuck, once settled [1]",
        f"peak_{called}_{in_a_name(command)}": f"largest {called} [{command}]",
        f"control_effort_{squared}": f"integral of the squared {called} [{command}2 s]",
        f"rms_{called}_change_{in_a_name(command)}": f"root mean square of the change of the "
        f"{called} from sample to sample [{command}]",
    }


def settled_samples(time: Floats, settled_after: float) -> Mask:
    """The samples at which the loop should have settled; all, if the motion ends before that."""
    goes_on = time[-1] > settled_after * (1.0 + SAME)
    return np.arange(len(time)) >= (first_at(time, settled_after) if goes_on else 0)


def late_samples(time: Floats) -> Floats:
    """1 and 2 in the two halves of the last quarter of a motion, before that 0."""
    left = len(time) - np.arange(len(time))  # samples from here to the end
    return np.where(8 * left <= len(time), 2.0, np.where(4 * left <= len(time), 1.0, 0.0))


def slides(rate: Floats) -> Mask:
    """Where an axis is to move at half its largest speed at least: not at rest or a reversal."""
    speed = np.abs(rate)
    return (speed > 0.0) & (speed * (1.0 + SAME) >= 0.5 * speed.max(initial=0.0))


def metrics(
    drive: Drive, motion: Any, speed: Floats, commanded: Floats, time: Floats, settled_after: float
) -> dict[str, float | None]:
    """``meanings`` of one recorded motion, in numbers; all None where it diverged.

    ``motion`` has ``error``, ``error_rate`` and ``command``, each (steps,); ``speed`` and
    ``commanded`` are the velocity that the axis has and the one it should have. "Once settled"
    means after ``settled_after`` [s], the same for every design; a loop that ends earlier is
    looked at as a whole. A loop that never settles has no settling time.
    """
    if not all(np.isfinite(part).all() for part in (motion.error, speed, motion.command)):
        return dict.fromkeys(meanings(drive))
    error = np.abs(motion.error)
    late = settled_samples(time, settled_after)
    stuck = is_stuck(speed, commanded)[late]
    large = np.flatnonzero(error > SETTLED * error.max())
    settled = 0 if len(large) == 0 else large[-1] + 1
    sample_time = time[1] - time[0] if len(time) > 1 else 0.0
    numbers = (
        np.sqrt(np.mean(error**2)),
        error.max(),
        np.sum(error) * sample_time,
        motion.error[-1],
        time[settled] if settled < len(time) else None,
        np.sqrt(np.mean(motion.error_rate[late] ** 2)),
        stuck.mean(),
        np.count_nonzero(stuck & ~np.concatenate([[False], stuck[:-1]])),
        np.abs(motion.command).max(),
        np.sum(motion.command**2) * sample_time,
        np.sqrt(np.mean(np.diff(motion.command) ** 2)) if len(time) > 1 else None,
    )
    values = (None if value is None else float(value) for value in numbers)
    return dict(zip(meanings(drive), values, strict=True))
