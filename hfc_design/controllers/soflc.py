"""The self-organising fuzzy controller of a feed drive (Jee & Koren 1995), for the simulator."""

from functools import cache, partial

from hfc_design.controllers.controller import Controller, summed
from hfc_design.controllers.lanes import LANES
from hfc_design.laws import aflc as law
from hfc_design.laws.adaptation import blamed_soflc


@cache
def soflc(sample_time: float) -> Controller:
    """The controller of kind ``soflc``, sampled every ``sample_time`` [s].

    Its gains are ``AdaptiveGains``.
    """
    parts = partial(law.parts, LANES, blamed_soflc, sample_time)
    return Controller("soflc", law.initial_memory, summed(parts))
