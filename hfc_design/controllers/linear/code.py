"""What explanations and other programs need of a linear law, alone or as a part of another one.

Never imports JAX.
"""

from hfc_design.controllers.linear.law import AHEAD, Parts
from hfc_design.controllers.linear.record import MULTIPLES, LinearDesign
from hfc_design.controllers.rules import identifier
from hfc_design.core.numbers import Json

#: The gains of a resonator.
TURNING = ("in_phase", "quadrature")


def resonators(record: LinearDesign) -> list[Json]:
    """Of each resonator its frequency, its rotation in a sample and its gains."""
    found = []
    pairs = zip(record.resonators, record.structure.rotations, strict=True)
    for one, (cosine, sine) in pairs:
        found.append(one.model_dump() | {"cosine": cosine, "sine": sine})
    return found


def step(record: LinearDesign, name: str) -> str:
    """What the part ``name`` of a law adds to kp and kd at a sample, in words."""
    terms = [f"{name}.signals.{identifier(signal)} * {signal}" for signal in record.signals]
    terms += [f"{name}.velocity * reference_rate", f"{name}.acceleration * reference_acceleration"]
    terms += [
        f"{name}.coulomb * min(max(reference_rate / {name}.coulomb_width, -1), 1)",
        f"{name}.load",
    ]
    return " + ".join(terms)


def integral_step(gain: str) -> str:
    """How the integral grows, in words; ``gain`` has ``{}`` for its name."""
    return (
        "integral: 0 before the first sample; behind each command it grows by "
        f"{gain.replace('{}', 'ki')} * "
        "sample_time_s * error, unless command is beyond largest_command in the direction in "
        "which it would grow"
    )


def resonator_step(gain: str) -> str:
    """How a resonator goes on, in words; ``gain`` has ``{}`` for the name of one of its gains."""
    along, across = (gain.replace("{}", f"resonators.{name}") for name in TURNING)
    return (
        "each resonator: share and behind, both 0 before the first sample; behind each command "
        f"share becomes cosine * share + sine * behind + {along} * sample_time_s * error and "
        f"behind becomes cosine * behind - sine * share - {across} * sample_time_s * error, both "
        "of share and behind as they were; without what error adds if command is beyond "
        "largest_command in the direction in which share would be pushed"
    )


def about(record: LinearDesign, units: dict[str, str]) -> Json:
    """The numbers of ``step``, and unit of every signal in them."""
    gains = record.gains()
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
    found = {"proportional": parts.proportional, "integral": parts.integral}
    found["derivative"] = parts.derivative
    found |= dict(zip(record.signals, parts.signals, strict=True))
    found |= {f"feed-forward of {name}": getattr(parts, name) for name in MULTIPLES}
    pairs = zip(record.resonators, parts.resonators, strict=False)  # a scheduled law has no own
    found |= {f"resonator of {one.frequency_rad_s:g} rad/s": share for one, share in pairs}
    return {name: float(value) for name, value in found.items()}
