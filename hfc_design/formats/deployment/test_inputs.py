"""Inputs that drive a controller through its whole range and beyond, the same at every export.

Sweeps, steps that are held for a while, a rest, small swings, and values that come by chance. Of
Python's own generator, whose numbers are the same in every release.
"""

from collections.abc import Callable, Iterator, Sequence
from math import cos, pi, sin, tau
from random import Random

from hfc_design.controllers.kind import ControllerRecord

#: Samples of each part of the vectors.
SWEEPS, STEPS, REST, SMALL, CHANCE = 250, 200, 25, 75, 450
COUNT = SWEEPS + STEPS + REST + SMALL + CHANCE
#: Samples before which all is forgotten, so that what learns is seen with what it starts from too.
RESETS = frozenset((0, *range(COUNT - CHANCE, COUNT, 30)))
#: How far the inputs go, in shares of the range.
BEYOND = 1.4
#: The change of an error in a sample, as a signal of ``ControllerRecord.input_range``.
CHANGE = "error_change"


def input_ranges_of(
    record: ControllerRecord, axes: tuple[str, ...], limits: dict[str, float | None]
) -> dict[str, dict[str, float]]:
    """How far the range of a controller goes on each axis, see ``ControllerRecord.input_range``.

    Of what is made around others it is the farther one of both.
    """
    ranges = {axis: dict(record.input_range(limits[axis])) for axis in axes}
    for inner_axis, inner in record.inside(axes).items():
        of = (inner_axis,) if inner_axis else axes
        for axis, sizes in input_ranges_of(inner, of, limits).items():
            for name, size in sizes.items():
                ranges[axis][name] = max(size, ranges[axis].get(name, 0.0))
    return ranges


def driven(names: Sequence[str], sizes: dict[str, float], seed: str) -> list[list[float]]:
    """(COUNT, names) of what one axis tells; the ``seed`` tells axes apart."""
    random = Random(seed)
    step = sizes.get(CHANGE, 0.0)
    columns = [
        list(_signal(random, sizes.get(name, 1.0), step if name == "error" else 0.0))
        for name in names
    ]
    return [list(row) for row in zip(*columns, strict=True)]


def connected(
    rows: list[list[float]], names: Sequence[str], fed_back: str, sizes: dict[str, float]
) -> list[list[float]]:
    """Rows of what is ``driven`` as those of a machine that is near its reference.

    It is switched off now and then, takes over, and leaves its reference farther than it may.
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
        for name, on in switched.items():
            if name in places:
                row[places[name]] = float(on(k)) * (0.9 * size if name == "largest_error" else 1.0)
    return rows


def path(sizes: dict[str, float], count: int) -> list[list[float]]:
    """(COUNT, count) tangent, curvature and contour error of a path in X-Y, bent to both sides.

    ``sizes`` are of the X axis; without the contour error where ``count`` is 3.
    """
    random, size = Random("path"), sizes.get("error", 1.0)
    off = _signal(random, size, 0.0)
    rows = []
    for k, contour_error in enumerate(off):
        angle, bent = tau * k / 90.0, 0.1 / size * sin(tau * k / 137.0)
        rows.append([*map(_short, (cos(angle), sin(angle), bent)), contour_error][:count])
    return rows


def _signal(random: Random, size: float, step: float) -> Iterator[float]:
    """A signal of ``COUNT`` samples that goes a little beyond ``size``.

    With a ``step`` its change in a sample goes a little beyond that too, wherever the signal is.
    """
    yield from (_short(BEYOND * size * x) for x in _shares(random))
    for _ in range(CHANCE // 2):
        value, change, other = (BEYOND * random.uniform(-1.0, 1.0) for _ in range(3))
        before = size * value - step * change if step else size * other
        yield from (0.0 if random.random() < 0.05 else _short(x) for x in (before, size * value))


def _shares(random: Random) -> Iterator[float]:
    """What comes before chance, from -1 to 1."""
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
    """Seven digits, which single precision holds as well."""
    return float(f"{value:.6e}")
