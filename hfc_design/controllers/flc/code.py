"""A fuzzy controller in C and in Structured Text."""

from itertools import pairwise
from pathlib import Path

from hfc_design.controllers.flc.law import STANDSTILL, FlcGains
from hfc_design.controllers.flc.record import FlcDesign, FuzzyRecord
from hfc_design.controllers.flc.rules import units
from hfc_design.controllers.kind import Template
from hfc_design.controllers.rules import Triangle
from hfc_design.core.shapes import Json

HERE = Path(__file__).parent / "templates"


def c_values(record: FuzzyRecord, table: FlcGains) -> Json:
    """What the template needs of a controller that starts from a ``table``."""
    error_terms, change_terms = table.error_terms, table.change_terms
    return {
        "adaptive": False,
        "start": "",
        "current": "",
        "integrates": bool(table.k_i) or record.control_form() == "PI",
        "form": record.control_form(),
        "error_centres": [term[1] for term in error_terms],
        "change_centres": [term[1] for term in change_terms],
        "error_joints": [(lower[2], upper[0]) for lower, upper in pairwise(error_terms)],
        "change_joints": [(lower[2], upper[0]) for lower, upper in pairwise(change_terms)],
        "table": table.singletons,
        "integral": table.k_i * record.sample_time_s,
        "compensation": table.compensation,
        "standstill": STANDSTILL,
    }


def _c(record: FlcDesign) -> Json:
    return c_values(record, record.gains())


def _st(record: FuzzyRecord) -> Json:
    """An adaptation is left out: the block holds the table that it starts from and says so."""
    constants: Json = {
        "integral_gain": record.integral_gain,
        "sample_time": record.sample_time_s,
    }
    (unit,) = units(record)
    for name, terms in ((unit.row, unit.row_terms), (unit.column, unit.column_terms)):
        triangles = [term for term in terms if isinstance(term, Triangle)]
        # The outermost edges are infinite and not read.
        constants[f"{name}_left"] = [0.0, *(term.left for term in triangles[1:])]
        constants[f"{name}_centre"] = [term.centre for term in triangles]
        constants[f"{name}_right"] = [*(term.right for term in triangles[:-1]), 0.0]
    within = ["degree", "error_change", "new_action", "new_integral"]
    low = record.low_velocity
    if low:
        within += ["v", "compensation"]
        constants |= {
            "forward": low.forward,
            "backward": low.backward,
            "breakaway": low.breakaway,
            "highest_velocity": low.highest_velocity_mm_s,
            "smallest_error": low.smallest_error,
            "blu": low.blu_mm,
        }
    return {
        "constants": constants,
        "remembered": ["previous_error", "control_action", "integral"],
        "within": within,
        "units": [unit],
        "form": record.control_form(),
        "leaves_out": record.adapts,
    }


C = Template((HERE,), _c)
ST = Template((HERE,), _st)
