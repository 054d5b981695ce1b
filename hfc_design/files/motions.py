"""Several motions of a scenario that are judged together."""

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal, TypeAlias

import numpy as np
from pydantic import Field, model_validator

from hfc_design.core.numbers import Floats, State
from hfc_design.core.records import Finite, NotNegative, Positive, Record
from hfc_design.core.wording import one_of
from hfc_design.files.machine import Axis
from hfc_design.motion.references import EachAxis, Load, Reference
from hfc_design.motion.trajectories import PathReference
from plants import Drive, Machine

AnyReference = Annotated[Reference | PathReference | EachAxis, Field(discriminator="kind")]
#: Initial displacement of the copy of a loop: this share of the travel of its axis (in its fastest
#: second at most), but at least so many steps of its resolution; for an axis at rest, see below.
DISTURBANCE, LEAST_STEPS = 0.01, 100
STILL_RAD, STILL_MM = 1e-3, 0.01
#: State at the start. With one axis: name of a state -> value; with several: axis -> such a table.
Start: TypeAlias = dict[str, Finite | dict[str, Finite]]


class Motion(Record):
    """One of several motions; keys that it leaves out are those of the scenario."""

    name: Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9-]{0,31}$")]  # name of the motion
    weight: Positive = 1.0  # weight of its cost relative to the others [1]
    #: machines on which it is judged: all, or only the nominal one
    machines: Literal["all", "nominal"] = "all"
    duration_s: Positive | None = None  # left out: simulation.duration_s [s]
    settled_after_s: NotNegative | None = None  # left out: fitness.settled_after_s [s]
    reference: AnyReference | None = None  # left out: [reference] of the scenario
    load: Load | None = None  # left out: [load] of the scenario
    start: Start | None = None  # left out: [start] of the scenario [of the state]

    def ends_settled(self, duration: float) -> None:
        """Check that the motion continues after its settling time; ValueError: it does not."""
        if self.settled_after_s is not None and self.settled_after_s >= duration:
            raise ValueError(
                f"settled_after_s = {self.settled_after_s}: must be less than its "
                f"duration of {duration} s"
            )

    @model_validator(mode="before")
    @classmethod
    def _one_clock(cls, data: Any) -> Any:
        if isinstance(data, dict):
            for key in ("simulation", "sample_time_s", "substeps"):
                if key in data:
                    raise ValueError(
                        f"{key}: must be set for the whole scenario; all motions share its clock"
                    )
        return data


def started(
    machine: Machine, start: Mapping[str, Any], places: Mapping[str, float] | None = None
) -> tuple[State, ...]:
    """Return the state of each axis before the first sample, in numbers.

    ``places`` are the positions of the axes (default: 0), unless ``start`` sets others.

    Raises:
        ValueError: the machine has no such axis or state.
    """
    axis_starts = dict(start) if len(machine.axes) > 1 else {machine.axes[0]: start}
    for axis in axis_starts:
        if axis not in machine.axes:
            raise ValueError(f"start.{axis}: unknown axis; {one_of(axis, machine.axes)}")
    states = []
    each = zip(machine.axes, machine.drives, machine.initial_state(0.0), strict=True)
    for axis, drive, zero in each:
        state = put(drive, zero, (places or {}).get(axis, 0.0))
        for name, value in axis_starts.get(axis, {}).items():
            if name not in state._fields or isinstance(value, dict):
                known = one_of(name, state._fields)
                raise ValueError(f"start.{name}: unknown state of the machine; {known}")
        states.append(state._replace(**axis_starts.get(axis, {})))
    return tuple(states)


def put(drive: Drive, state: State, off: float) -> State:
    """Return the state with all positions of an axis shifted by ``off``."""
    places = {drive.position, drive.seen[0], *drive.encoders}
    shifted = {name: getattr(state, name) + off for name in places if name in state._fields}
    return state._replace(**shifted)


def way(target: Floats, rate: Floats) -> float:
    """Return an axis' travel, at most in its fastest second, from positions and rates (steps,)."""
    speed, whole = float(np.abs(rate).max()), float(np.abs(target).max())
    return min(whole, speed) if speed else whole


def copy_started(
    axes: Sequence[Axis], start: Sequence[State], ways: Sequence[float], finest: Sequence[float]
) -> tuple[State, ...]:
    """Return ``start`` with all positions of each axis shifted a little (``objectives.unsettled``).

    ``ways`` are the travels of the axes, ``finest`` the encoder steps that the scenario sets, both
    in the units of the axes.
    """
    perturbed = []
    for axis, state, way, step in zip(axes, start, ways, finest, strict=True):
        still = STILL_MM / axis.length if axis.length else STILL_RAD
        whole = float(axis.drive.commanded(np.array(0.25))) != 0.25
        coarsest = max(step, axis.resolution, float(whole))
        off = max(DISTURBANCE * way, LEAST_STEPS * coarsest) or still
        perturbed.append(put(axis.drive, state, off))
    return tuple(perturbed)
