"""What is to be identified: which machine, of it which parameters, and in which loop."""

from collections.abc import Sequence
from typing import NamedTuple

from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.files.scenario import Scenario
from hfc_design.identify.free import Free, free


class Task(NamedTuple):
    """What is to be identified, and how."""

    scenario: Scenario  # its plant with the values to start from, sensors, limits
    axis: int  # which one
    design: Design | None  # the controller in the loop that recorded the logs
    names: Sequence[str] | None  # parameters that are looked for; None: all that may be
    bandwidth: float | None  # of the observer [Hz]; 0: open loop; None: that of the least residual
    seed: int = 0
    made: bool = False  # the scenario says no more than which machine it is


def looked_for(task: Task) -> Free:
    """The parameters that are looked for.

    Raises:
        UserError: one is unknown, or has no value to start from.
    """
    start = task.scenario.plant.each()[task.axis]
    changes = start.parameters._asdict()
    nominal = start.drive.parameters()._asdict()
    own = {key: value for key, value in changes.items() if value != nominal[key]}
    try:
        return free(start.drive, own, task.names)
    except ValueError as error:
        raise UserError(f"--free {error}") from None
