"""A PD controller in a design file. Never imports JAX."""

from typing import Literal

from hfc_design.controllers.kind import ControllerRecord
from hfc_design.controllers.pd.law import PdGains
from hfc_design.core.records import Finite, Record


class PdRecord(Record):
    """Gains of LL eq. 6."""

    kp: Finite  # [V/rad]
    kd: Finite  # [V s/rad]


class PdDesign(ControllerRecord):
    """A controller of kind ``pd``."""

    kind: Literal["pd"] = "pd"
    pd: PdRecord

    def gains(self) -> PdGains:
        """The gains of one individual."""
        return PdGains(self.pd.kp, self.pd.kd)
