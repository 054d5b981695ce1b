"""Numbers with their derivatives (slopes), to differentiate a law without compiling it."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from hfc_design.core.numbers import ARRAYS, Floats, Scalar

#: Function of NumPy -> (its output, its arguments) -> its derivatives by the arguments.
SLOPES: Mapping[Any, Callable[..., tuple[Any, ...]]] = {
    np.add: lambda output, a, b: (1.0, 1.0),
    np.subtract: lambda output, a, b: (1.0, -1.0),
    np.negative: lambda output, a: (-1.0,),
    np.multiply: lambda output, a, b: (b, a),
    np.divide: lambda output, a, b: (1.0 / b, -output / b),
    np.power: lambda output, a, power: (_steep(a, power), np.nan),  # exponents are constants
    np.absolute: lambda output, a: (np.sign(a),),
    np.exp: lambda output, a: (output,),
    np.tanh: lambda output, a: (1.0 - output**2,),
    np.minimum: lambda output, a, b: (a < b, ~(a < b)),
    np.maximum: lambda output, a, b: (a > b, ~(a > b)),
}


class Sloped(NDArrayOperatorsMixin):
    """Numbers (points,) and their slopes (variables, points), for laws written with ``xp``."""

    def __init__(self, value: Any, slope: Any):
        self.value, self.slope = value, slope

    def __array_ufunc__(self, function: Any, method: str, *given: Any) -> Any:
        values = [_parts(x)[0] for x in given]
        output = function(*values)
        if output.dtype == bool:
            return output
        each = zip(SLOPES[function](output, *values), given, strict=True)
        slopes = [factor * x.slope for factor, x in each if isinstance(x, Sloped)]
        return Sloped(output, sum(slopes[1:], slopes[0]))


def _steep(a: Any, power: float) -> Any:
    with np.errstate(divide="ignore", invalid="ignore"):
        steep = power * a ** (power - 1)  # infinite for a root at 0, to both sides: 0 on average
    return np.where(np.isfinite(steep), steep, 0.0)


def _parts(x: Any) -> tuple[Any, Any]:
    return (x.value, x.slope) if isinstance(x, Sloped) else (x, 0.0)


def parts(x: Any, variables: int, lanes: int) -> tuple[Floats, Floats]:
    """Return the values (lanes,) and slopes (variables, lanes) of a number at ``lanes`` points."""
    value, slope = _parts(x)
    return np.broadcast_to(value, lanes), np.broadcast_to(slope, (variables, lanes))


def _where(condition: Any, a: Any, b: Any) -> Any:
    (value, slope), (other, falls) = _parts(a), _parts(b)
    selected = np.where(condition, value, other)
    some = isinstance(a, Sloped) or isinstance(b, Sloped)
    return Sloped(selected, np.where(condition, slope, falls)) if some else selected


def _pick(values: Mapping[int, Scalar], index: Any) -> Any:
    (_, result), *others = values.items()
    for k, value in others:
        result = _where(np.asarray(index) == k, value, result)
    return result


#: The functions that laws are written with, for ``Sloped`` numbers.
SLOPED = ARRAYS._replace(where=_where, pick=_pick)
