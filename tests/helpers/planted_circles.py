"""Circles of pure geometry with planted causes of deviations; lengths in mm."""

import numpy as np

from hfc_design.motion.circularity import OFFSET, RADIUS, REST, SCALE, SERVO, SQUARE, full_turns

CAUSES = [f"{what} of {axis}" for what in ("backlash", "reversal spikes") for axis in "XY"]
CAUSES += [SERVO, SCALE, SQUARE, RADIUS, OFFSET, REST]
#: Shapes of spikes over the angle since the reversal, by their width [rad].
SHAPES = [
    lambda since, width: np.where(since < width, np.sin(np.pi * since / width), 0.0),
    lambda since, width: np.exp(-(((since - width) / (width / 2)) ** 2)),
    lambda since, width: np.clip(1.0 - np.abs(since - width / 2) / (width / 2), 0.0, None),
    lambda since, width: np.exp(-since / width),
]


def planted(random, cause, largest=0.2, directions=(1, -1)):
    """Radius, turns and sizes of a circle whose ``cause`` is dominant.

    The others have up to a share ``largest`` of its size, of any sign. The positions have noise of
    0.5 um, are rounded to the step of an encoder, and overlap by a part of a turn.
    """
    radius, feed = random.uniform(20.0, 300.0), random.uniform(5.0, 100.0)
    size = random.uniform(0.015, 0.06)
    sizes = {x: random.uniform(0.0, largest) * size * random.choice([-1, 1]) for x in CAUSES}
    sizes[cause] = size * random.choice([-1, 1])
    lobes, shapes, widths = (
        random.integers(9, 60),
        random.integers(0, 4, 2),
        random.uniform(1, 12, 2),
    )
    begin, phase, way = random.uniform(0.0, 2 * np.pi, 3)
    step, every = random.choice([1e-4, 1e-3, 2e-3]), random.choice([0.001, 0.002, 0.004])
    crosses = random.choice([True, False])
    turns = {}
    for side in directions:
        count = int(2 * np.pi * radius * (1 + random.uniform(0.05, 1.0)) / (feed * every))
        angle = begin + side * np.linspace(0.0, count * feed * every / radius, min(count, 15_000))
        place = _place(angle, side, radius, sizes, (lobes, phase, way), shapes, widths, crosses)
        place = step * np.round((place + random.normal(0.0, 0.0005, place.shape)) / step)
        turns[side] = place[:, full_turns(place, radius)[0][side]]
    return radius, turns, {x: abs(one) for x, one in sizes.items()}


def _place(angle, side, radius, sizes, rest, shapes, widths, crosses):
    lobes, phase, way = rest
    unit = np.stack([np.cos(angle), np.sin(angle)])
    off = np.zeros_like(unit)
    for k, axis in enumerate("XY"):
        since = np.mod(side * (angle - k * np.pi / 2), np.pi)
        outwards = np.sign(np.cos(angle - k * np.pi / 2 - side * since))  # of the reversal
        backlash = sizes[f"backlash of {axis}"]
        crossed = np.full_like(since, 0.5)
        if crosses and backlash > 0.0:  # the table stands until the motor has crossed the gap
            crossed = (
                np.minimum(radius * (1.0 - np.cos(np.minimum(since, 1.0))) / backlash, 1) - 0.5
            )
        off[k] += outwards * crossed * backlash
        spike = SHAPES[shapes[k]](since, np.radians(widths[k]))
        off[k] += outwards * abs(sizes[f"reversal spikes of {axis}"]) * spike
        off[k] += (0.5 - k) * sizes[SCALE] * unit[k]
    off[0] += (sizes[SQUARE] + side * sizes[SERVO]) * unit[1]  # a lag of Y leaves X ahead
    off += (sizes[RADIUS] + 0.5 * abs(sizes[REST]) * np.sin(lobes * angle + phase)) * unit
    return radius * unit + off + 0.5 * sizes[OFFSET] * np.array([[np.cos(way)], [np.sin(way)]])
