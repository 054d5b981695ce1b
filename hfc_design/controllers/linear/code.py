"""What explanations and other programs need of a linear law, alone or as a part of another one.

Never imports JAX.
"""

from hfc_design.controllers.kind import Explain
from hfc_design.controllers.linear.law import AHEAD, Parts
from hfc_design.controllers.linear.record import MULTIPLES, LinearDesign
from hfc_design.controllers.rules import identifier
from hfc_design.core.numbers import Json


def resonators(record: LinearDesign) -> list[Json]:
    """Of each resonator its frequency, its rotation in a sample and its gains."""
    entries = []
    pairs = zip(record.resonators, record.form.rotations, strict=True)
    for one, (cosine, sine) in pairs:
        entries.append(one.model_dump() | {"cosine": cosine, "sine": sine})
    return entries


def about(record: LinearDesign, units: dict[str, str]) -> Json:
    """The numbers of a law, and unit of every signal that they are of."""
    gains = record.law_gains()
    read = dict.fromkeys([*record.signals, *AHEAD])
    return {
        "ki": gains.ki,
        "signals": {identifier(name): gain for name, gain in record.signals.items()},
        **{name: getattr(gains, name) for name in MULTIPLES},
        "coulomb_width": gains.width,
        **({"resonators": resonators(record)} if record.resonators else {}),
        "reads": {identifier(name): units.get(name, "") for name in read},
    }


def shares(record: LinearDesign, parts: Parts) -> dict[str, float]:
    """What a command is made of, by its names for people."""
    contributions = {"proportional": parts.proportional, "integral": parts.integral}
    contributions["derivative"] = parts.derivative
    contributions |= dict(zip(record.signals, parts.signals, strict=True))
    contributions |= {f"feed-forward of {name}": getattr(parts, name) for name in MULTIPLES}
    pairs = zip(record.resonators, parts.resonators, strict=False)  # a scheduled law has no own
    contributions |= {f"resonator of {one.frequency_rad_s:g} rad/s": share for one, share in pairs}
    return {name: float(value) for name, value in contributions.items()}


EXPLAIN = Explain(
    signals=lambda record: (record.reads(), []),
    remember=lambda memory, readings: memory,  # nothing of it is a reading
    shown=lambda record, parts: {"units": [], "parts": shares(record, parts)},
)
