"""The fuzzy controller of a feed drive, for the population simulator."""

from functools import cache, partial

from hfc_design.controllers.controller import Controller, summed
from hfc_design.controllers.flc import law
from hfc_design.core.lanes import LANES


@cache
def flc(form: str, sample_time: float) -> Controller:
    """The controller of kind ``flc`` and ``form`` P, PI or PD, sampled every ``sample_time`` [s].

    Its gains are ``FlcGains``.
    """
    parts = partial(law.parts, LANES, form, sample_time)
    return Controller("flc", law.initial_memory, summed(parts))
