"""Numbers that carry their slopes: every law has one at a point, found without compiling it."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from hfc_design.core.numbers import ARRAYS, Floats, Mask, Scalar


class Sloped:
    """(lanes,) numbers and their slopes (variables, lanes), as a law written with ``xp`` takes."""

    __array_ufunc__ = None  # an array on the left leaves the work to this class

    def __init__(self, value: Any, slope: Any):
        self.value, self.slope = value, slope

    def __add__(self, other: Any) -> "Sloped":
        value, slope = _parts(other)
        return Sloped(self.value + value, self.slope + slope)

    __radd__ = __add__

    def __neg__(self) -> "Sloped":
        return Sloped(-self.value, -self.slope)

    def __sub__(self, other: Any) -> "Sloped":
        return self + -other

    def __rsub__(self, other: Any) -> "Sloped":
        return -self + other

    def __mul__(self, other: Any) -> "Sloped":
        value, slope = _parts(other)
        own = self.slope * value
        return Sloped(self.value * value, own + self.value * slope if _is(other) else own)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> "Sloped":
        value, slope = _parts(other)
        found = self.value / value
        return Sloped(found, (self.slope - found * slope) / value)

    def __rtruediv__(self, other: Any) -> "Sloped":
        found = other / self.value
        return Sloped(found, -found / self.value * self.slope)

    def __pow__(self, power: float) -> "Sloped":
        with np.errstate(divide="ignore", invalid="ignore"):
            steep = power * self.value ** (power - 1)  # of a root at 0 either way: 0 in the mean
        return Sloped(self.value**power, np.where(np.isfinite(steep), steep, 0.0) * self.slope)

    def __abs__(self) -> "Sloped":
        return Sloped(np.abs(self.value), np.sign(self.value) * self.slope)

    def __lt__(self, other: Any) -> Mask:
        return np.asarray(self.value < _parts(other)[0])

    def __le__(self, other: Any) -> Mask:
        return np.asarray(self.value <= _parts(other)[0])

    def __gt__(self, other: Any) -> Mask:
        return np.asarray(self.value > _parts(other)[0])

    def __ge__(self, other: Any) -> Mask:
        return np.asarray(self.value >= _parts(other)[0])


def _is(x: Any) -> bool:
    return isinstance(x, Sloped)


def _parts(x: Any) -> tuple[Any, Any]:
    return (x.value, x.slope) if isinstance(x, Sloped) else (x, 0.0)


def parts(x: Any, variables: int, lanes: int) -> tuple[Floats, Floats]:
    """A number and its slopes, whole: (lanes,) and (variables, lanes)."""
    value, slope = _parts(x)
    return np.broadcast_to(value, lanes), np.broadcast_to(slope, (variables, lanes))


def _where(condition: Any, a: Any, b: Any) -> Any:
    if not _is(a) and not _is(b):
        return np.where(condition, a, b)
    (value, slope), (other, falls) = _parts(a), _parts(b)
    return Sloped(np.where(condition, value, other), np.where(condition, slope, falls))


def _bell(rate: float, distance: Any) -> Any:
    if not _is(distance):
        return ARRAYS.bell(rate, distance)
    value = ARRAYS.bell(rate, distance.value)
    return Sloped(value, -2.0 * rate * distance.value * value * distance.slope)


def _tanh(x: Any) -> Any:
    if not _is(x):
        return np.tanh(x)
    value = np.tanh(x.value)
    return Sloped(value, (1.0 - value**2) * x.slope)


def _pick(values: Mapping[int, Scalar], index: Any) -> Any:
    (_, result), *others = values.items()
    for k, value in others:
        result = _where(np.asarray(index) == k, value, result)
    return result


#: The functions that laws are written with, on such numbers.
SLOPED = ARRAYS._replace(
    where=_where,
    minimum=lambda a, b: _where(a < b, a, b),
    maximum=lambda a, b: _where(a > b, a, b),
    bell=_bell,
    tanh=_tanh,
    ratio=lambda a, b: a / b,
    pick=_pick,
)
