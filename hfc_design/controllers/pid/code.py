"""The PID law in C and in Structured Text."""

from pathlib import Path
from typing import Any

from hfc_design.controllers.kind import Template
from hfc_design.controllers.pid.record import PidDesign

HERE = (Path(__file__).parent / "templates",)


def _c(record: PidDesign) -> dict[str, Any]:
    return {"gains": record.gains(), "integrates": True}


def _st(record: PidDesign) -> dict[str, Any]:
    part = record.pid
    return {
        "constants": {
            "kp": part.k_p,
            "ki": part.k_i,
            "kd": part.k_d,
            "sample_time": record.sample_time_s,
        },
        "remembered": ["previous_error", "error_sum"],
        "within": ["new_sum"],
    }


C = Template(HERE, _c)
ST = Template(HERE, _st)
