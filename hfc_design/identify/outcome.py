"""Everything that a log tells of a machine, as data."""

from typing import NamedTuple

from hfc_design.core.numbers import Floats
from hfc_design.files.machine import Axis
from hfc_design.identify.advice import Advice, Profile
from hfc_design.identify.fit import Fit
from hfc_design.identify.identifiability import Certainty
from hfc_design.identify.parameters import Free
from hfc_design.identify.recording import Recording
from hfc_design.identify.request import Task
from hfc_design.identify.response import Response


class Check(NamedTuple):
    """A log replayed with the parameters that were found, or with those of the start."""

    log: str
    how: str  # under the recorded command, or in closed loop
    before: float  # rms residual with the parameters of the start [unit of the position]
    after: float
    residual: Floats  # (steps,) recorded less simulated


class Outcome(NamedTuple):
    """What was found, and what speaks against it."""

    log: str  # its name
    task: Task
    fit: Fit
    known: Certainty
    profiles: tuple[Profile, ...]
    checks: tuple[Check, ...]
    advice: Advice | None
    response: Response | None
    recording: Recording
    notes: tuple[str, ...]

    @property
    def axis(self) -> Axis:
        """The one of the machine, as the fit began."""
        return self.task.one

    @property
    def free(self) -> Free:
        """The parameters that were looked for."""
        return self.fit.free

    @property
    def position_unit(self) -> str:
        """Of the residual."""
        return self.free.drive.units["error"]
