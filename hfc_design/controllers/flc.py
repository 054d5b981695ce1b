"""The fuzzy controller of a feed drive, for the population simulator."""

from functools import cache, partial

from hfc_design.controllers.controller import Controller
from hfc_design.controllers.lanes import LANES
from hfc_design.laws import flc as law


@cache
def flc(form: str, sample_time: float) -> Controller:
    """The controller of kind ``flc`` and ``form`` P, PI or PD, sampled every ``sample_time`` [s].

    Its gains are ``FlcGains``.
    """
    return Controller("flc", law.initial_memory, partial(law.step, LANES, form, sample_time))
