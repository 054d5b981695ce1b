"""The PD controller that every fuzzy one is measured against."""

from hfc_design.controllers.controller import Controller
from hfc_design.controllers.pd.law import PdGains, law

__all__ = ["PdGains", "law", "pd"]


def pd() -> Controller:
    """The controller of kind ``pd``; it remembers nothing."""
    return _PD


_PD = Controller(
    "pd", lambda zero: (), lambda gains, memory, signals: (law(gains, signals), memory)
)
