"""Outputs of many FLL engines; runs in the environment of pyfuzzylite: JSON from stdin to stdout.

What differs from the highest degree, or from the middle of an area, by rounding only is made equal
to it, so that no last bit decides which places are as high as the highest.
"""

import json
import sys

import fuzzylite as fl
import numpy as np

job = json.load(sys.stdin)
exact = fl.Aggregated.membership


def level(self, x):
    degrees = np.atleast_2d(exact(self, x))
    highest = degrees.max(axis=1, keepdims=True)
    return np.where(degrees >= (1.0 - 1e-14) * highest, highest, degrees)


class Numbers:
    """NumPy, but for distances: those that are as small as the smallest are equal to it."""

    def __getattr__(self, name):
        return getattr(np, name)

    def abs(self, x):
        least = np.abs(x).min(axis=1, keepdims=True)
        return np.where(np.abs(x) <= least + 1e-12, least, np.abs(x))


fl.Aggregated.membership = level
fl.defuzzifier.np = Numbers()
outputs = []
for text, points in zip(job["texts"], job["points"], strict=True):
    engine = fl.FllImporter().from_string(text)
    for variable, values in zip(engine.input_variables, points, strict=True):
        variable.value = np.array(values)
    with np.errstate(all="ignore"):
        engine.process()
    found = np.broadcast_to(engine.output_variables[0].value, len(points[0]))
    outputs.append([None if np.isnan(value) else float(value) for value in found])
json.dump(outputs, sys.stdout)
