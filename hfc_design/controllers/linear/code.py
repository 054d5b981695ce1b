"""Data on a linear law for explanations and exports, alone or as a part of another law.

Never imports JAX.
"""

from hfc_design.controllers.kind import Explain
from hfc_design.controllers.linear.law import AHEAD, Parts
from hfc_design.controllers.linear.record import MULTIPLES, LinearDesign
from hfc_design.controllers.rules import identifier
from hfc_design.core.numbers import Json


def about(record: LinearDesign, units: dict[str, str]) -> Json:
    """Return by key all gains but kp and kd, and the units of the signals besides the errors."""
    gains, pairs = record.law_gains(), zip(record.resonators, record.form.rotations, strict=True)
    turning = [one.model_dump() | dict(zip(("cosine", "sine"), x, strict=True)) for one, x in pairs]
    filters = dict(zip(record.form.filters, gains.filters, strict=True))
    read = dict.fromkeys([*record.signals, *AHEAD])
    return {
        "ki": gains.ki,
        "signals": {identifier(name): gain for name, gain in record.signals.items()},
        **{name: getattr(gains, name) for name in MULTIPLES},
        "coulomb_width": gains.width,
        **({"resonators": turning} if turning else {}),
        **({"filters": filters} if filters else {}),
        "reads": {identifier(name): units.get(name, "") for name in read},
    }


def shares(record: LinearDesign, parts: Parts) -> dict[str, float]:
    """Return the parts of a command by the names that users see."""
    contributions = {"proportional": parts.proportional, "integral": parts.integral}
    contributions["derivative"] = parts.derivative
    contributions |= dict(zip(record.signals, parts.signals, strict=True))
    contributions |= {f"feed-forward of {name}": getattr(parts, name) for name in MULTIPLES}
    pairs = zip(record.resonators, parts.resonators, strict=False)  # none if scheduled
    contributions |= {f"resonator of {one.frequency_rad_s:g} rad/s": share for one, share in pairs}
    contributions |= {"filters": parts.filters} if record.form.filters else {}
    return {name: float(value) for name, value in contributions.items()}


EXPLAIN = Explain(
    signals=lambda record: (record.reads(), []),
    remember=lambda memory, readings: memory,  # it holds no readings
    shown=lambda record, parts: {"units": [], "parts": shares(record, parts)},
)
