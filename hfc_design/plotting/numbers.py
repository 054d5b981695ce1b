"""Numbers for readers: scores, and numbers with a unit that suits their size."""

from math import isfinite

from plants import in_a_name

#: Units with names for a thousandth and a millionth, which are used for small numbers.
SMALLER = {
    unit: tuple(
        (factor, f"{prefix}{unit}") for factor, prefix in ((1e6, "µ"), (1e3, "m"), (1.0, ""))
    )
    for unit in ("rad", "rad/s", "m", "m/s", "V")
} | {unit: ((1e3, unit.replace("mm", "µm")), (1.0, unit)) for unit in ("mm", "mm/s")}


def readable(unit: str, size: float) -> tuple[float, str]:
    """Return factor and unit that turn a number of a ``size`` into one without a power of ten."""
    steps = SMALLER.get(unit, ((1.0, unit),))
    return next((step for step in steps if abs(size) * step[0] < 1e3), steps[-1])


def metric(key: str, meaning: str) -> tuple[str, str]:
    """Return the name of a metric in tables, such as rms error, and its unit from ``meaning``."""
    unit = meaning.rpartition("[")[2].rstrip("]")
    words = key.replace("_", " ")
    for end in (in_a_name(unit), unit) if unit else ():
        words = words.removesuffix(" " + end.replace("_", " "))
    return words, unit


def digits(value: float, count: int = 4) -> str:
    """Return a number with ``count`` digits, or all before the point; from 1e6 on with a power."""
    return f"{value:.0f}" if 10.0**count <= abs(value) < 1e6 else f"{value:.{count}g}"


def score(value: float) -> str:
    """Return the text of a fitness or merit, small (of contour errors) or large (of Lin & Lee)."""
    if not isfinite(value):
        return "diverged"
    return f"{value:.1f}" if 10 <= abs(value) < 1e6 else f"{value:.4g}"
