"""The adaptive fuzzy controller of a feed drive (Jee & Koren 2004), for the simulator."""

from functools import cache, partial

from hfc_design.controllers.aflc import law
from hfc_design.controllers.aflc.adaptation import blamed_aflc
from hfc_design.controllers.controller import Controller, summed
from hfc_design.core.lanes import LANES


@cache
def aflc(sample_time: float) -> Controller:
    """The controller of kind ``aflc``, sampled every ``sample_time`` [s].

    Its gains are ``AdaptiveGains``.
    """
    parts = partial(law.parts, LANES, blamed_aflc, sample_time)
    return Controller("aflc", law.initial_memory, summed(parts))
