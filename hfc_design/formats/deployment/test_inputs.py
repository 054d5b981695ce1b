"""Test inputs that drive a controller through its whole range and beyond, the same at every export.

They are sweeps, steps that are held for a while, a rest, small swings, and random values. Python's
own generator makes the random numbers, the same in every release.
"""

from collections.abc import Callable, Iterator, Sequence
from math import cos, pi, sin, tau
from random import Random

from hfc_design.controllers.kind import ControllerRecord

#: Number of samples of each part: sweeps, steps, rest, small swings, random values.
SWEEPS, STEPS, REST, SMALL, CHANCE = 250, 200, 25, 75, 450
COUNT = SWEEPS + STEPS + REST + SMALL + CHANCE
#: Samples before which the memory is reset, so that the test also shows how learning starts.
RESETS = frozenset((0, *range(COUNT - CHANCE, COUNT, 30)))
#: Amplitude of the inputs relative to their ranges.
BEYOND = 1.4
#: Range, in steps of the sensor, above which ``connected`` moves a reading off whole steps.
FEW = 4.0
#: Key for the change of the error in one sample, as in ``ControllerRecord.input_range``.
CHANGE = "error_change"


def input_ranges_of(
    record: ControllerRecord, axes: tuple[str, ...], limits: dict[str, float | None]
) -> dict[str, dict[str, float]]:
    """Return axis -> signal -> range of a controller's inputs (``ControllerRecord.input_range``).

    If it has other controllers inside, the largest range of each signal counts.
    """
    ranges = {axis: dict(record.input_range(limits[axis])) for axis in axes}
    for inner_axis, inner in record.inside(axes).items():
        of = (inner_axis,) if inner_axis else axes
        for axis, sizes in input_ranges_of(inner, of, limits).items():
            for name, size in sizes.items():
                ranges[axis][name] = max(size, ranges[axis].get(name, 0.0))
    return ranges


def driven(names: Sequence[str], sizes: dict[str, float], seed: str) -> list[list[float]]:
    """Return test inputs (COUNT, names) for ranges ``sizes``; each axis has its own ``seed``."""
    random = Random(seed)
    step = sizes.get(CHANGE, 0.0)
    columns = [
        list(_signal(random, sizes.get(name, 1.0), step if name == "error" else 0.0))
        for name in names
    ]
    return [list(row) for row in zip(*columns, strict=True)]


def connected(
    rows: list[list[float]],
    names: Sequence[str],
    fed_back: str,
    sizes: dict[str, float],
    steps: dict[str, float],
) -> list[list[float]]:
    """Turn ``driven`` rows into readings of a machine that is near its reference.

    In some samples ``enable`` is off, ``take_over`` is on, or ``largest_error`` is exceeded.
    ``fed_back`` is the position reading. Readings with ``steps`` lie a quarter of a step beside a
    whole one, so that single precision rounds them as double does.
    """
    places = {name: k for k, name in enumerate(names)}
    size = sizes.get("error", 1.0)
    off = driven(["error"], sizes, "error")
    switched: dict[str, Callable[[int], bool]] = {
        "enable": lambda k: k % 97 < 90,
        "take_over": lambda k: k % 3 > 1,
        "largest_error": lambda k: k % 41 > 30,
    }
    for k, row in enumerate(rows):
        if "reference" in places and fed_back in places:
            row[places[fed_back]] = _short(row[places["reference"]] - off[k][0])
        for name, step in steps.items():
            if (
                name in places
                and sizes.get("error" if name == fed_back else name, 1.0) > FEW * step
            ):
                whole, aside = round(row[places[name]] / step), 0.25 * (-1.0) ** k
                row[places[name]] = _short(step * (whole + aside))
        for name, on in switched.items():
            if name in places:
                row[places[name]] = float(on(k)) * (0.9 * size if name == "largest_error" else 1.0)
    return rows


def path(sizes: dict[str, float], count: int) -> list[list[float]]:
    """Return inputs (COUNT, count) of an X-Y path that bends to both sides.

    They are tangent x, y, curvature and (``count`` 4) contour error; ``sizes`` are ranges of X.
    """
    random, size = Random("path"), sizes.get("error", 1.0)
    off = _signal(random, size, 0.0)
    rows = []
    for k, contour_error in enumerate(off):
        angle, bent = tau * k / 90.0, 0.1 / size * sin(tau * k / 137.0)
        rows.append([*map(_short, (cos(angle), sin(angle), bent)), contour_error][:count])
    return rows


def _signal(random: Random, size: float, step: float) -> Iterator[float]:
    """Yield a signal of ``COUNT`` samples, of up to ``BEYOND`` times ``size``.

    If ``step`` is not 0, its random values come in pairs that differ by up to ``BEYOND`` steps.
    """
    yield from (_short(BEYOND * size * x) for x in _shares(random))
    for _ in range(CHANCE // 2):
        value, change, other = (BEYOND * random.uniform(-1.0, 1.0) for _ in range(3))
        before = size * value - step * change if step else size * other
        yield from (0.0 if random.random() < 0.05 else _short(x) for x in (before, size * value))


def _shares(random: Random) -> Iterator[float]:
    """Yield sweeps, steps, rest and small swings as values from -1 to 1."""
    phase, slow, fast = pi * random.random(), random.uniform(70.0, 110.0), random.uniform(9.0, 14.0)
    for k in range(SWEEPS):
        yield 0.8 * sin(phase + tau * k / slow) + 0.2 * sin(tau * k / fast)
    samples_left, value = 0, 0.0
    for _ in range(STEPS):
        if samples_left == 0:
            samples_left = random.randrange(1, 12)
            value = 0.0 if random.random() < 0.15 else random.uniform(-1.0, 1.0)
        samples_left -= 1
        yield value
    yield from (0.0 for _ in range(REST))
    yield from (0.05 * sin(phase + tau * k / fast) for k in range(SMALL))


def _short(value: float) -> float:
    """Return the value with seven digits, about as many as single precision has."""
    return float(f"{value:.6e}")
