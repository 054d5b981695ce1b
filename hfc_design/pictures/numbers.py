"""Numbers as people read them: a score, and one with a unit that suits its size."""

from math import isfinite

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


def score(value: float) -> str:
    """A fitness or a merit as people read it: of contour errors small, by Lin & Lee large."""
    if not isfinite(value):
        return "diverged"
    return f"{value:.1f}" if abs(value) >= 10 else f"{value:.4g}"
