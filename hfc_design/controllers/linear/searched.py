"""A number that a search varies: its range, and how the range is divided."""

from typing import Any, NamedTuple

import numpy as np

from hfc_design.core.numbers import Floats


class Searched(NamedTuple):
    """A number that is varied: its range, how that is divided, where it starts."""

    low: float
    high: float
    start: float
    bend: float | None = None  # both signs, finer about 0; None: by logarithms, where above 0

    def value(self, place: Floats) -> Floats:
        """At a place of the range, 0 to 1."""
        if self.bend is not None:
            return self.high * np.sinh(self.bend * (2.0 * place - 1.0)) / np.sinh(self.bend)
        if self.low > 0.0:
            return np.asarray(self.low * (self.high / self.low) ** place)
        return self.low + place * (self.high - self.low)

    def place(self, value: Any) -> Floats:
        """The inverse of ``value``, within the range."""
        if self.bend is not None:
            share = np.arcsinh(value / self.high * np.sinh(self.bend)) / self.bend
            return np.clip(0.5 * (share + 1.0), 0.0, 1.0)
        inside = np.clip(value, self.low, self.high)
        if self.low == self.high:
            return np.zeros_like(inside)
        if self.low > 0.0:
            return np.asarray(np.log(inside / self.low) / np.log(self.high / self.low))
        return np.asarray((inside - self.low) / (self.high - self.low))
