"""The PID controller of a feed drive, for the population simulator."""

from functools import cache, partial

from hfc_design.controllers.controller import Controller
from hfc_design.controllers.pid import law


@cache
def pid(sample_time: float) -> Controller:
    """The controller of kind ``pid``, sampled every ``sample_time`` [s]; gains are ``PidGains``."""
    return Controller("pid", law.initial_memory, partial(law.step, sample_time))
