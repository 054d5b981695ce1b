"""Control laws whose gains are a few numbers, for the population simulator."""

from functools import cache, partial

from hfc_design.controllers.controller import Controller
from hfc_design.controllers.gains.law import Law


@cache
def of_law(law: Law, sample_time: float) -> Controller:
    """The controller that steps ``law`` every ``sample_time`` [s]; gains are the law's record."""
    return Controller(law.name, law.initial_memory, partial(law.step, sample_time))
