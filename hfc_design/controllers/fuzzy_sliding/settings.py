"""What a search for adaptive fuzzy sliding control starts from and may vary. Never imports JAX."""

from math import isfinite
from typing import Annotated, Literal

from pydantic import Field, field_validator

from hfc_design.controllers.fuzzy_sliding.record import (
    AdaptationRecord,
    SlidingDesign,
    SurfaceRecord,
)
from hfc_design.controllers.kind import ControllerSettings, Target
from hfc_design.controllers.start import controller_named
from hfc_design.core.records import Finite, Label, Table, ordered
from hfc_design.core.wording import one_of

#: LG09 Table 2 in thirds of LP: rows the error, columns its rate, both LN to LP.
TABLE_2 = (
    (-3, -3, -3, -3, -3, -3, -3),
    (-3, -3, -2, -2, -1, -1, -1),
    (-3, -2, -2, -1, -1, -1, 0),
    (0, 0, 0, 0, 0, 0, 0),
    (0, 1, 1, 1, 2, 2, 3),
    (1, 1, 1, 2, 2, 3, 3),
    (3, 3, 3, 3, 3, 3, 3),
)
#: LG09 Table 1: the proportional gain [1/s], speed over error.
GAIN = 33.33
#: Of a start that nobody gave: the switching part in shares of the largest command, its layer in
#: shares of the largest error, how long it takes to learn the command of a steady error [s].
SWITCHING, LAYER, LEARNING = 0.02, 0.05, 0.1


#: What is searched, and how many times larger or smaller than at the start it may become.
SEARCHED = {
    "largest_error": 10.0,
    "largest_error_rate": 10.0,
    "largest_consequent": 3.0,
    "slope": 10.0,
    "gain": 10.0,
    "boundary_layer": 10.0,
    "rate": 100.0,
    "largest_move": 10.0,
}


class SlidingSettings(ControllerSettings):
    """A fuzzy sliding controller to begin with, and what may vary about it."""

    kind: Literal["fuzzy-sliding"]
    #: a design or a record; left out: LG09 Table 2 with the scales of the machine
    start: SlidingDesign | None = Field(None, exclude_if=lambda start: start is None)
    #: [low, high] of numbers that are searched, other than about the start [of the number]
    ranges: dict[Label, Annotated[tuple[Finite, Finite], ordered]] = {}
    consequents: bool = False  # whether every consequent is searched too
    symmetric: bool = True  # both directions are treated alike

    _controller_of = field_validator("start", mode="before")(controller_named)

    @field_validator("ranges")
    @classmethod
    def _known(cls, ranges: dict[str, tuple[float, float]]) -> dict[str, tuple[float, float]]:
        for name in ranges:
            if name not in SEARCHED:
                raise ValueError(f"{name}: unknown; {one_of(name, SEARCHED)}")
        return ranges

    @property
    def staged(self) -> bool:
        """Yes: one stage, all that is searched."""
        return True

    def fault(self, target: Target) -> str | None:
        """Another sample time, or a machine whose scales are not known."""
        if self.start is None:
            command, speed = scales(target)
            if not (isfinite(command) and isfinite(speed) and command > 0.0 and speed > 0.0):
                return (
                    "controller.start: is missing; without one limits.command and a drive that "
                    "tells its top speed are needed"
                )
        elif self.start.sample_time_s != target.sample_time:
            return (
                f"controller.start: runs every {self.start.sample_time_s} s, "
                f"simulation.sample_time_s is {target.sample_time}"
            )
        return None


def scales(target: Target) -> tuple[float, float]:
    """The largest command and speed of the axes of a machine, the lowest of each."""
    limits = target.limits.values()
    axes = list(zip(target.machine.drives, target.parameters, limits, strict=True))
    commands = (abs(x) for drive, own, limit in axes for x in drive.largest_commands(own, limit))
    return min(commands), min(float(drive.top_speed(own)) for drive, own, _ in axes)


def started(target: Target) -> SlidingDesign:
    """LG09 Table 2 on the scales of a machine, in LG09's proportional gain.

    LP is the largest command, at the error at which the printed gain asks for it; as a rate it is
    the top speed. LG09 prints neither the surface nor gamma.
    """
    command, speed = scales(target)
    error = speed / GAIN
    return SlidingDesign(
        sample_time_s=target.sample_time,
        largest_error=error,
        largest_error_rate=speed,
        consequents=table_2(command),
        sliding=SurfaceRecord(
            slope=GAIN, gain=SWITCHING * command, boundary_layer=LAYER * GAIN * error
        ),
        adaptation=AdaptationRecord(
            rate=command / (GAIN * error * LEARNING), largest_move=command / 3.0
        ),
    )


def table_2(height: float) -> Table:
    """LG09 Table 2 with LP = ``height``."""
    return tuple(tuple(height * third / 3.0 for third in row) for row in TABLE_2)
