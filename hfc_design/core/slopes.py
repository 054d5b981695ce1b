"""Numbers that carry their slopes: every law has one at a point, found without compiling it."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from hfc_design.core.numbers import ARRAYS, Floats, Scalar

#: Derivatives of a function by its arguments, of what it gives and those.
SLOPES: Mapping[Any, Callable[..., tuple[Any, ...]]] = {
    np.add: lambda found, a, b: (1.0, 1.0),
    np.subtract: lambda found, a, b: (1.0, -1.0),
    np.negative: lambda found, a: (-1.0,),
    np.multiply: lambda found, a, b: (b, a),
    np.divide: lambda found, a, b: (1.0 / b, -found / b),
    np.power: lambda found, a, power: (_steep(a, power), np.nan),  # no law has a slope of a power
    np.absolute: lambda found, a: (np.sign(a),),
    np.exp: lambda found, a: (found,),
    np.tanh: lambda found, a: (1.0 - found**2,),
    np.minimum: lambda found, a, b: (a < b, ~(a < b)),
    np.maximum: lambda found, a, b: (a > b, ~(a > b)),
}


class Sloped(NDArrayOperatorsMixin):
    """(lanes,) numbers and their slopes (variables, lanes), as a law written with ``xp`` takes."""

    def __init__(self, value: Any, slope: Any):
        self.value, self.slope = value, slope

    def __array_ufunc__(self, function: Any, method: str, *given: Any) -> Any:
        values = [_parts(x)[0] for x in given]
        found = function(*values)
        if found.dtype == bool:
            return found
        each = zip(SLOPES[function](found, *values), given, strict=True)
        slopes = [factor * x.slope for factor, x in each if isinstance(x, Sloped)]
        return Sloped(found, sum(slopes[1:], slopes[0]))


def _steep(a: Any, power: float) -> Any:
    with np.errstate(divide="ignore", invalid="ignore"):
        steep = power * a ** (power - 1)  # of a root at 0 either way: 0 in the mean
    return np.where(np.isfinite(steep), steep, 0.0)


def _parts(x: Any) -> tuple[Any, Any]:
    return (x.value, x.slope) if isinstance(x, Sloped) else (x, 0.0)


def parts(x: Any, variables: int, lanes: int) -> tuple[Floats, Floats]:
    """A number and its slopes, whole: (lanes,) and (variables, lanes)."""
    value, slope = _parts(x)
    return np.broadcast_to(value, lanes), np.broadcast_to(slope, (variables, lanes))


def _where(condition: Any, a: Any, b: Any) -> Any:
    (value, slope), (other, falls) = _parts(a), _parts(b)
    found = np.where(condition, value, other)
    some = isinstance(a, Sloped) or isinstance(b, Sloped)
    return Sloped(found, np.where(condition, slope, falls)) if some else found


def _pick(values: Mapping[int, Scalar], index: Any) -> Any:
    (_, result), *others = values.items()
    for k, value in others:
        result = _where(np.asarray(index) == k, value, result)
    return result


#: The functions that laws are written with, on such numbers.
SLOPED = ARRAYS._replace(where=_where, pick=_pick)
