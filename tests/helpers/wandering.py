"""Random signals for a design: all over its universe and beyond."""

import numpy as np

from hfc_design.formats import code

#: How far the signals of a random run go: beyond the universe of a C-axis design.
REACH = {"error": 0.03, "deflection": 0.02, "error_rate": 0.1, "velocity": 900.0}


def wandering(design, seed=0, count=3000):
    """Signals (count, signals) that go all over the universe and beyond, with jumps and rests."""
    random = np.random.default_rng(seed)
    names = code.signals(design)
    if design.plant.name == "c-axis":
        scales = {item.name: item.scale for item in getattr(design.controller, "inputs", ())}
        reach = [1.2 / scales[name] if name in scales else REACH.get(name, 1.0) for name in names]
        return random.uniform(-1.0, 1.0, (count, len(reach))) * reach
    if design.plant.name == "milling-table":  # from the scale's steps to far beyond every set
        swings = 0.4 * np.sin(np.arange(count) / 40.0) * np.exp(-np.arange(count) / count)
        error, highest = swings + random.normal(0.0, 0.01, count), 20.0
    else:
        error = 25.0 * np.sin(np.arange(count) / 40.0) + random.normal(0.0, 1.0, count)
        error[::50] = random.uniform(-40.0, 40.0, error[::50].size)
        error[1000:1100] = 0.0
        error[2000:] = np.round(error[2000:])  # as an encoder counts, where degrees are alike
        highest = 900.0
    signals = {"error": error, "velocity": highest * np.sin(np.arange(count) / 70.0)}
    signals["error_rate"] = 100.0 * np.gradient(error)
    signals["reference_rate"] = signals["velocity"] + signals["error_rate"]
    signals["reference_acceleration"] = 100.0 * np.gradient(signals["reference_rate"])
    return np.stack([signals[name] for name in names], axis=1)
