"""The fitness of Lin & Lee (1999), eq. 5."""

from functools import cache
from typing import Literal

import jax.numpy as jnp
from jax.tree_util import Partial
from pydantic import model_validator

from hfc_design.core.numbers import Scalar
from hfc_design.core.records import NotNegative
from hfc_design.motion.samples import PathFrame
from hfc_design.objectives import objective
from hfc_design.objectives.objective import FINEST, Moment, Objective, Remaining, Sums


class LinLeeSettings(objective.ObjectiveSettings):
    """Weights a and b of LL eq. 5."""

    kind: Literal["lin-lee"] = "lin-lee"
    error: NotNegative = 3.0  # weight a of the error, LL eq. 5 [1]
    error_rate: NotNegative = 0.1  # weight b of the rate of the error, LL eq. 5 [1]

    @model_validator(mode="after")
    def _weighs_something(self) -> "LinLeeSettings":
        if not self.error and not self.error_rate:
            raise ValueError("at least one of the two weights must be positive")
        return self


@cache
def lin_lee(error_weight: float = 3.0, error_rate_weight: float = 0.1) -> Objective:
    """Return LL eq. 5: ``a 1000 / sum |e| + b 1000 / sum |de/dt|``, sums over samples and axes."""
    score = Partial(_score, error_weight, error_rate_weight)
    return Objective(
        initial=_nothing,
        update=_update,
        score=score,
        best=score,
        name="lin-lee",
        title="fitness, LL eq. 5",
        meaning="eq. 5 of Lin & Lee (1999)",
        positive=True,
        settings=LinLeeSettings,
        make=lambda settings: lin_lee(settings.error, settings.error_rate),
    )


def _nothing(zero: Scalar) -> Sums:
    return zero, zero


def _update(sums: Sums, moments: tuple[Moment, ...], path: PathFrame | None) -> Sums:
    return (
        sums[0] + sum(jnp.abs(moment.error) for moment in moments),
        sums[1] + sum(jnp.abs(moment.error_rate) for moment in moments),
    )


def _score(
    error: Scalar, error_rate: Scalar, sums: Sums, left: Remaining = objective.NONE_REMAINING
) -> Scalar:
    total, rate = (jnp.maximum(one, FINEST) for one in sums)  # both sums only grow
    return 1000.0 * (error / total + error_rate / rate)


OBJECTIVE = lin_lee()
