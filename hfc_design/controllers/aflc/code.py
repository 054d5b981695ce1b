"""The fuzzy controllers that adapt, in C; in Structured Text they are those they start from."""

from pathlib import Path

from hfc_design.controllers.aflc import law
from hfc_design.controllers.aflc.adaptation import ALIKE, PERFORMANCE, blamed_aflc
from hfc_design.controllers.aflc.record import AdaptiveDesign
from hfc_design.controllers.flc.code import HERE as FLC
from hfc_design.controllers.flc.code import ST, c_values
from hfc_design.controllers.flc.law import FlcGains
from hfc_design.controllers.flc.sectors import ZR
from hfc_design.controllers.kind import Template
from hfc_design.core.scalars import SCALARS
from hfc_design.core.shapes import Json

#: Where the templates of the adaptation lie.
ADAPTATION = (Path(__file__).parent / "templates",)


def c_template(blamed: law.Blame) -> Template:
    """The template of a controller whose rules are ``blamed`` so."""

    def values(record: AdaptiveDesign) -> Json:
        """It starts from what its law makes of the design at the first sample."""
        start = record.gains()
        memory = law.initial_memory(law.aflc(record.sample_time_s), 0.0)
        terms = law.adapted(SCALARS, blamed, start, memory, 0.0)
        table = FlcGains(*terms, start.flc.k_i, start.flc.compensation)
        return c_values(record, table) | {
            "adaptive": True,
            "start": "start_",
            "current": "state->",
            "rates": start.rates,
            "sectors": start.sectors,
            "positive": [
                [int(u >= 0.0 if i > ZR else u > 0.0) for u in row]
                for i, row in enumerate(start.flc.singletons)
            ],
            "blames_what_it_did": blamed is blamed_aflc,
            "alike": ALIKE,
            "performance": PERFORMANCE,
        }

    return Template((*ADAPTATION, FLC), values)


C = c_template(blamed_aflc)
__all__ = ["ADAPTATION", "ST", "C", "c_template"]
