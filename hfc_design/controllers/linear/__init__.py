"""Linear controllers with feed-forward: PID tuned by a search, and optimal regulators.

All have one law. Of ``pid+ff`` every gain is searched; of ``lqr`` and ``lqi`` weights are, and the
gains follow from them and from the linearised drive.
"""

from pathlib import Path
from typing import Any

from hfc_design.controllers.controller import AxisLaw
from hfc_design.controllers.kind import Explain, Kind, Template, later
from hfc_design.controllers.linear.law import (
    LinearMemory,
    Parts,
    initial_memory,
    sample,
)
from hfc_design.controllers.linear.record import (
    LinearDesign,
    LqiDesign,
    LqiSettings,
    LqrDesign,
    LqrSettings,
    PidDesign,
    PidSettings,
)
from hfc_design.controllers.rules import identifier
from hfc_design.core.numbers import Json

GENOMES = {"pid_genome": "PidGenome", "lq_genome": "LqGenome"}
HERE = (Path(__file__).parent / "templates",)


def _law(record: LinearDesign, limit: float | None) -> AxisLaw:
    names = tuple(record.signals)
    return AxisLaw(sample, initial_memory, record.sample_time_s, limit, names)


def _c(record: LinearDesign) -> Json:
    fed_back = {identifier(name): gain for name, gain in record.signals.items()}
    return {"gains": record.gains(), "kept": record.kept, "fed_back": fed_back, "integrates": True}


def _st(record: LinearDesign) -> Json:
    own, gains = _c(record), record.gains()
    ahead = {
        f"ahead_{k}": getattr(gains, k) for k in ("velocity", "acceleration", "coulomb", "load")
    }
    constants = {
        "kp": gains.kp,
        "ki": gains.ki,
        "kd": gains.kd,
        **{f"gain_{name}": gain for name, gain in own["fed_back"].items()},
        **ahead,
        "coulomb_width": gains.width,
        "filter_kept": gains.kept,
        "filter_taken": 1.0 - gains.kept,
        "sample_time": record.sample_time_s,
    }
    return {
        "constants": constants,
        "remembered": ["error_integral", "error_rate_filtered"],
        "within": ["new_rate", "direction", "new_integral"],
        "fed_back": own["fed_back"],
    }


def _remember(memory: LinearMemory, readings: dict[str, float]) -> LinearMemory:
    return memory  # nothing of it is a reading


def _shown(record: LinearDesign, parts: Parts) -> Json:
    """Shares of the command; there are no units with rules."""
    shares = {"proportional": parts.proportional, "integral": parts.integral}
    shares["derivative"] = parts.derivative
    shares |= dict(zip(record.signals, parts.signals, strict=True))
    ahead = ("velocity", "acceleration", "coulomb", "load")
    shares |= {f"feed-forward of {name}": getattr(parts, name) for name in ahead}
    return {"units": [], "parts": {name: float(value) for name, value in shares.items()}}


def _kind(name: str, summary: str, record: type[LinearDesign], settings: Any, genome: str) -> Kind:
    here = "hfc_design.controllers.linear"
    return Kind(
        name=name,
        summary=summary,
        record=record,
        settings=settings,
        gains=LinearDesign.gains,
        law=_law,
        genome=later(f"{here}.{genome}", GENOMES[genome]),
        reads=LinearDesign.reads,
        of_gains=dict,
        c=Template(HERE, _c),
        st=Template(HERE, _st),
        explain=Explain(lambda record: (record.reads(), []), _remember, _shown),
        open_loop=later(f"{here}.model", "open_loop"),
        sections=later(f"{here}.section", "sections"),
    )


KINDS = (
    _kind("pid+ff", "PID with filter and feed-forward", PidDesign, PidSettings, "pid_genome"),
    _kind("lqr", "optimal state feedback with feed-forward", LqrDesign, LqrSettings, "lq_genome"),
    _kind(
        "lqi",
        "optimal state feedback with integral and feed-forward",
        LqiDesign,
        LqiSettings,
        "lq_genome",
    ),
)
