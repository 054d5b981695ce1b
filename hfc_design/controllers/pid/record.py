"""A PID controller in a design file. Never imports JAX."""

from typing import Literal

from hfc_design.controllers.kind import ControllerRecord
from hfc_design.controllers.pid.law import PidGains
from hfc_design.core.records import Finite, Record


class PidRecord(Record):
    """Gains of ``pid.step``."""

    k_p: Finite  # [units/BLU]
    k_i: Finite  # [units/(BLU s)]
    k_d: Finite  # [units s/BLU]


class PidDesign(ControllerRecord):
    """A controller of kind ``pid``."""

    kind: Literal["pid"] = "pid"
    pid: PidRecord

    def gains(self) -> PidGains:
        """The gains of one individual."""
        return PidGains(self.pid.k_p, self.pid.k_i, self.pid.k_d)
