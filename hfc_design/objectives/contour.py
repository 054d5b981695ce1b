"""The contour error of a machine on a path as a fitness."""

from functools import cache
from typing import Literal, Self

import jax.numpy as jnp
from jax.tree_util import Partial
from pydantic import PrivateAttr

from hfc_design.core.numbers import Scalar
from hfc_design.core.records import NotNegative
from hfc_design.motion.contour import off_path
from hfc_design.motion.samples import PathFrame
from hfc_design.objectives import objective
from hfc_design.objectives.metric import Units
from hfc_design.objectives.objective import FINEST, Moment, Objective, Remaining, Sums


class ContourSettings(objective.ObjectiveSettings):
    """Weights of ``contour``."""

    kind: Literal["contour"] = "contour"
    worst: NotNegative = 0.3  # weight of the largest contour error [1]
    lag: NotNegative = 0.01  # weight of the rms of the lag along the path [1]
    _unit: str = PrivateAttr("BLU")  # unit of the machine's positions

    def on(self, units: Units) -> Self:
        """Return the same settings for a machine with these units."""
        settings = self.model_copy()
        settings._unit = units.signals["error"]
        return settings


@cache
def contour(worst: float = 0.3, lag: float = 0.01, unit: str = "BLU") -> Objective:
    """Return the objective ``1 / (rms + worst * largest + lag * rms lag)`` [1/unit of positions].

    The first two are the rms and the largest contour error. If there are rotary axes, the error is
    the root of the squared contour error plus the squared orientation error (a degree counts as a
    unit of length). The lag is the distance of the machine behind its reference along the path: it
    penalises a machine that never leaves the path because it never moves.
    """
    return Objective(
        initial=_nothing,
        update=_update,
        score=Partial(_best, worst, lag),
        best=Partial(_best, worst, lag),
        name="contour",
        title="fitness",
        unit=f"1/{unit}",
        meaning=f"1 / (rms + {worst:g} × largest + {lag:g} × rms lag) of the contour error "
        f"[1/{unit}]",
        positive=True,
        settings=ContourSettings,
        make=lambda settings: contour(settings.worst, settings.lag, settings._unit),
        fault=_fault,
    )


def _nothing(zero: Scalar) -> Sums:
    return zero, zero, zero, zero


def _update(sums: Sums, moments: tuple[Moment, ...], path: PathFrame | None) -> Sums:
    assert path is not None  # see ``_fault``
    squares, largest, lags, count = sums
    error, turned, behind = off_path(path, [moment.deviation for moment in moments])
    error = error if turned is None else jnp.hypot(error, turned)
    largest = jnp.maximum(largest, jnp.abs(error))
    return squares + error * error, largest, lags + behind * behind, count + 1.0


def _best(
    worst: Scalar, lag: Scalar, sums: Sums, left: Remaining = objective.NONE_REMAINING
) -> Scalar:
    squares, largest, lags, count = sums
    count = count + left.samples
    cost = jnp.sqrt(squares / count) + worst * largest + lag * jnp.sqrt(lags / count)
    return 1.0 / jnp.maximum(cost, FINEST)


def _fault(axes: int, path: bool) -> str | None:
    of = "one axis" if axes == 1 else "axes that do not follow a path"
    return None if path else f"a machine of {of} has no contour"


OBJECTIVE = contour()
