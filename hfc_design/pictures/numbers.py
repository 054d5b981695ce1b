"""Numbers as people read them: a score, and one with a unit that suits its size."""

from math import isfinite

from plants import in_a_name

#: Units that have names for a thousandth and a millionth, in which small numbers are read.
SMALLER = {
    unit: tuple(
        (factor, f"{prefix}{unit}") for factor, prefix in ((1e6, "µ"), (1e3, "m"), (1.0, ""))
    )
    for unit in ("rad", "rad/s", "m", "m/s", "V")
} | {unit: ((1e3, unit.replace("mm", "µm")), (1.0, unit)) for unit in ("mm", "mm/s")}


def readable(unit: str, size: float) -> tuple[float, str]:
    """Factor and unit that make of a number of a ``size`` one that needs no power of ten."""
    steps = SMALLER.get(unit, ((1.0, unit),))
    return next((step for step in steps if abs(size) * step[0] < 1e3), steps[-1])


def metric(key: str, meaning: str) -> tuple[str, str]:
    """What tables call a metric, and its unit, with which its ``meaning`` ends: rms error, rad."""
    unit = meaning.rpartition("[")[2].rstrip("]")
    words = key.replace("_", " ")
    for end in (in_a_name(unit), unit) if unit else ():
        words = words.removesuffix(" " + end.replace("_", " "))
    return words, unit


def digits(value: float, count: int = 4) -> str:
    """So many digits, or all that stand before the point; from 1e6 on a power of ten."""
    return f"{value:.0f}" if 10.0**count <= abs(value) < 1e6 else f"{value:.{count}g}"


def score(value: float) -> str:
    """A fitness or a merit as people read it: of contour errors small, by Lin & Lee large."""
    if not isfinite(value):
        return "diverged"
    return f"{value:.1f}" if 10 <= abs(value) < 1e6 else f"{value:.4g}"
