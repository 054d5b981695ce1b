"""The self-organising fuzzy controller of a feed drive (Jee & Koren 1995), for the simulator."""

from functools import cache, partial

from hfc_design.controllers.aflc import law
from hfc_design.controllers.aflc.adaptation import blamed_soflc
from hfc_design.controllers.controller import Controller, summed
from hfc_design.core.lanes import LANES


@cache
def soflc(sample_time: float) -> Controller:
    """The controller of kind ``soflc``, sampled every ``sample_time`` [s].

    Its gains are ``AdaptiveGains``.
    """
    parts = partial(law.parts, LANES, blamed_soflc, sample_time)
    return Controller("soflc", law.initial_memory, summed(parts))
