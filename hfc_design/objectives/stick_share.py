"""Share of the time in which an axis sticks although it should move.

LL eq. 5 rewards loops that oscillate about the reference so fast that the spindle stops again and
again; such loops mislead a search and are useless on a machine.
"""

from functools import cache
from typing import Literal

import jax.numpy as jnp
from jax.tree_util import Partial

from hfc_design.core.numbers import Scalar, Truth
from hfc_design.core.records import Positive
from hfc_design.motion.samples import PathFrame
from hfc_design.objectives import objective
from hfc_design.objectives.objective import Moment, Objective, Remaining, Sums

#: Below this share of the commanded speed an axis counts as stuck.
STUCK = 0.1


class StickShareSettings(objective.ObjectiveSettings):
    """Weight of ``stick_share``."""

    kind: Literal["stick-share"] = "stick-share"
    weight: Positive = 1.0  # factor on the share [1]


def is_stuck(speed: Scalar, commanded: Scalar) -> Truth:
    """Return whether an axis moves at less than a tenth of its commanded speed."""
    return abs(speed) < STUCK * abs(commanded)


@cache
def stick_share(weight: float = 1.0) -> Objective:
    """Return the objective ``-weight * share of the settled time in which an axis sticks``."""
    return Objective(
        initial=_nothing,
        update=_update,
        score=Partial(_best, weight),
        best=Partial(_best, weight),
        name="stick-share",
        title=f"-{weight:g} stick share",
        unit="1",
        meaning=f"-{weight:g} times the share of the settled time at which an axis sticks",
        settings=StickShareSettings,
        make=lambda settings: stick_share(settings.weight),
    )


def _nothing(zero: Scalar) -> Sums:
    return zero, zero


def _update(sums: Sums, moments: tuple[Moment, ...], path: PathFrame | None) -> Sums:
    stuck, settled = sums
    for moment in moments:
        now = is_stuck(moment.reference_rate - moment.error_rate, moment.reference_rate)
        stuck = stuck + jnp.where(now, moment.settled, 0.0)
        settled = settled + moment.settled
    return stuck, settled


def _best(weight: Scalar, sums: Sums, left: Remaining = objective.NONE_REMAINING) -> Scalar:
    stuck, settled = sums
    return -(weight * stuck / jnp.maximum(settled + left.settled, 1.0))


OBJECTIVE = stick_share()
