"""The contour error of an X-Y machine as a fitness."""

from functools import cache, reduce
from typing import Literal

import jax.numpy as jnp

from hfc_design.core.numbers import Scalar
from hfc_design.core.records import NotNegative
from hfc_design.motion.contour import contour_error
from hfc_design.motion.samples import PathFrame
from hfc_design.objectives.objective import Left, Moment, Objective, ObjectiveSettings, Sums


class ContourSettings(ObjectiveSettings):
    """Weights of ``contour``."""

    kind: Literal["contour"] = "contour"
    worst: NotNegative = 0.3  # of the largest contour error
    lag: NotNegative = 0.01


@cache
def contour(worst: float = 0.3, lag: float = 0.01) -> Objective:
    """``1 / (rms + worst * largest + lag * rms lag)`` of an X-Y machine [1/BLU].

    The first two are of the contour error. The lag is how far the machine is behind along the
    path: one that never leaves the path because it never moves is no good.
    """

    def update(sums: Sums, moments: tuple[Moment, ...], path: PathFrame | None) -> Sums:
        assert path is not None  # see ``_fault``
        squares, largest, lags, count = sums
        off = [moment.deviation for moment in moments]
        error = contour_error(path, off)
        each = zip(off, path.tangent, strict=True)
        behind = reduce(jnp.add, [a * t for a, t in each if t is not None])
        largest = jnp.maximum(largest, jnp.abs(error))
        return squares + error * error, largest, lags + behind * behind, count + 1.0

    def best(sums: Sums, left: Left) -> Scalar:
        squares, largest, lags, count = sums
        count = count + left.samples
        return 1.0 / (jnp.sqrt(squares / count) + worst * largest + lag * jnp.sqrt(lags / count))

    return Objective(
        initial=lambda zero: (zero, zero, zero, zero),
        update=update,
        score=lambda sums: best(sums, Left(0.0, 0.0)),
        best=best,
        name="contour",
        title="fitness",
        unit="1/BLU",
        meaning=f"1 / (rms + {worst:g} × largest + {lag:g} × rms lag) of the contour error [1/BLU]",
        positive=True,
        settings=ContourSettings,
        make=lambda own: contour(own.worst, own.lag),
        fault=_fault,
    )


def _fault(axes: int, path: bool) -> str | None:
    if path:
        return None
    return f"a machine of {'one axis' if axes == 1 else 'axes that follow no path'} has no contour"


OBJECTIVE = contour()
