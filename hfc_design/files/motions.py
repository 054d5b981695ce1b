"""The motions that a scenario judges together."""

from collections.abc import Mapping
from typing import Annotated, Any, TypeAlias

from pydantic import Field, model_validator

from hfc_design.core.numbers import State
from hfc_design.core.records import Finite, NotNegative, Positive, Record
from hfc_design.motion.references import EachAxis, Load, Reference
from hfc_design.motion.trajectories import PathReference
from plants import Machine

AnyReference = Annotated[Reference | PathReference | EachAxis, Field(discriminator="kind")]
#: Of a machine of one axis: state -> value at the start; of several: axis -> such a table.
Start: TypeAlias = dict[str, Finite | dict[str, Finite]]


class Motion(Record):
    """One of several motions; what it leaves out is what the scenario says for all."""

    name: Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9-]{0,31}$")]
    weight: Positive = 1.0  # of its cost among those of the others
    duration_s: Positive | None = None
    settled_after_s: NotNegative | None = None
    reference: AnyReference | None = None
    load: Load | None = None
    start: Start | None = None

    @model_validator(mode="before")
    @classmethod
    def _one_clock(cls, data: Any) -> Any:
        if isinstance(data, dict):
            for key in ("simulation", "sample_time_s", "substeps"):
                if key in data:
                    raise ValueError(f"{key}: all motions have the clock of the scenario")
        return data


def started(machine: Machine, start: Mapping[str, Any]) -> tuple[State, ...]:
    """The state of each axis before the first sample, numbers.

    Raises:
        ValueError: the machine has no such axis or state.
    """
    own = dict(start) if len(machine.axes) > 1 else {machine.axes[0]: start}
    for axis in own:
        if axis not in machine.axes:
            raise ValueError(f"start.{axis}: no axis; there is {', '.join(machine.axes)}")
    states = []
    for axis, state in zip(machine.axes, machine.initial_state(0.0), strict=True):
        for name, value in own.get(axis, {}).items():
            if name not in state._fields or isinstance(value, dict):
                known = ", ".join(state._fields)
                raise ValueError(f"start.{name}: no state of the machine; there is {known}")
        states.append(state._replace(**own.get(axis, {})))
    return tuple(states)
