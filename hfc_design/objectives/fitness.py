"""What a good closed loop is: the score that is searched and the metrics that are read.

A score is accumulated sample by sample inside the loop, so that its memory does not grow with
the number of samples; the metrics look at a whole recorded trajectory.
"""

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from hfc_design.core.plugins import Group
from hfc_design.motion.contour import local_error
from plants import Drive, in_a_name

Floats = NDArray[np.float64]


class Moment(NamedTuple):
    """What a fitness sees of one axis at one sample; scalars in the units of the plant."""

    error: Any
    error_rate: Any
    deviation: Any  # from where the axis should be, its sign the other way round
    command: Any
    reference_rate: Any
    settled: Any  # 1 once the loop should have settled, before that 0


class Fitness(NamedTuple):
    """A score as pure functions of scalars.

    ``initial(zero)`` gives empty sums, ``update(sums, moments, path)`` adds one sample of every
    axis, ``score(sums)`` is the number that the search maximises: more than zero, because a loop
    that diverges counts 0. ``path`` is a ``PathFrame`` of scalars, None for a machine of one axis.
    """

    initial: Callable[[Any], Any]
    update: Callable[[Any, tuple[Moment, ...], Any], Any]
    score: Callable[[Any], Any]
    name: str = ""  # of a user's own, the ``kind`` in a scenario


#: Fitnesses that users add; what is built in has settings, see ``scenarios``.
OWN_FITNESSES: Group[Fitness] = Group(
    "fitness", Fitness, "hfc_design.objectives.fitness", {}, frozenset({"lin-lee", "contour"})
)


@cache
def lin_lee(error_weight: float = 3.0, error_rate_weight: float = 0.1) -> Fitness:
    """LL eq. 5: ``a 1000 / sum |e| + b 1000 / sum |de/dt|`` over control samples and axes."""

    def score(sums: tuple[Any, Any]) -> Any:
        error, error_rate = sums
        return 1000.0 * (error_weight / error + error_rate_weight / error_rate)

    return Fitness(
        initial=lambda zero: (zero, zero),
        update=lambda sums, moments, path: (
            sums[0] + sum(jnp.abs(moment.error) for moment in moments),
            sums[1] + sum(jnp.abs(moment.error_rate) for moment in moments),
        ),
        score=score,
    )


@cache
def contour(worst: float, lag: float) -> Fitness:
    """``1 / (rms + worst * largest + lag * rms lag)`` of an X-Y machine [1/BLU].

    The first two are of the contour error. The lag is how far the machine is behind along the
    path: one that never leaves the path because it never moves is no good.
    """

    def update(sums: Any, moments: tuple[Moment, ...], path: Any) -> Any:
        squares, largest, lags, count = sums
        x, y = (moment.deviation for moment in moments)
        error = local_error(x, y, path.tangent_x, path.tangent_y, path.curvature)
        behind = x * path.tangent_x + y * path.tangent_y
        return (
            squares + error * error,
            jnp.maximum(largest, jnp.abs(error)),
            lags + behind * behind,
            count + 1.0,
        )

    def score(sums: Any) -> Any:
        squares, largest, lags, count = sums
        return 1.0 / (jnp.sqrt(squares / count) + worst * largest + lag * jnp.sqrt(lags / count))

    return Fitness(lambda zero: (zero, zero, zero, zero), update, score)


@cache
def without_sticking(fitness: Fitness, penalty: float) -> Fitness:
    """``fitness / (1 + penalty * stick share)``, the share of the settled time.

    LL eq. 5 rewards loops that swing about the reference so fast that the spindle stops again
    and again; they are a dead end for a search, and no good on a machine.
    """

    def update(sums: Any, moments: tuple[Moment, ...], path: Any) -> Any:
        inner, stuck, settled = sums
        for moment in moments:
            now = is_stuck(moment.reference_rate - moment.error_rate, moment.reference_rate)
            stuck = stuck + jnp.where(now, moment.settled, 0.0)
            settled = settled + moment.settled
        return fitness.update(inner, moments, path), stuck, settled

    def score(sums: Any) -> Any:
        inner, stuck, settled = sums
        return fitness.score(inner) / (1.0 + penalty * stuck / jnp.maximum(settled, 1.0))

    return Fitness(lambda zero: (fitness.initial(zero), zero, zero), update, score, fitness.name)


#: Below this share of the commanded speed the spindle counts as stuck.
STUCK = 0.1


def is_stuck(speed: Any, commanded: Any) -> Any:
    """Whether an axis moves at less than a tenth of its commanded speed."""
    return abs(speed) < STUCK * abs(commanded)


#: The loop has settled once its error stays below this share of its maximum.
SETTLED = 0.1


def meanings(drive: Drive) -> dict[str, str]:
    """Name -> meaning and unit of each metric of one axis, in the order of every table."""
    error, rate, command = (drive.units[name] for name in ("error", "error_rate", "command"))
    called, squared = drive.command_name, f"{in_a_name(command)}2s"
    return {
        f"rms_error_{in_a_name(error)}": f"root mean square of the tracking error [{error}]",
        f"max_error_{in_a_name(error)}": f"largest tracking error [{error}]",
        f"iae_{in_a_name(error)}_s": f"integral of the tracking error's magnitude [{error} s]",
        f"final_error_{in_a_name(error)}": f"tracking error at the last sample [{error}]",
        "settling_time_s": "from then on the error stays below a tenth of its maximum [s]",
        f"velocity_ripple_{in_a_name(rate)}": f"rms of the velocity error once settled [{rate}]",
        "stick_share": "share of the time, once settled, below a tenth of the commanded speed [1]",
        "stick_events": "how often the axis stuck, once settled [1]",
        f"peak_{called}_{in_a_name(command)}": f"largest {called} [{command}]",
        f"control_effort_{squared}": f"integral of the squared {called} [{command}2 s]",
    }


def settled_samples(time: Floats, settled_after: float) -> NDArray[np.bool_]:
    """The samples at which the loop should have settled; all, if the motion ends before that."""
    return time >= (settled_after if time[-1] > settled_after else 0.0)


def metrics(
    drive: Drive,
    motion: Any,
    speed: Floats,
    commanded: Floats,
    time: Floats,
    settled_after: float,
) -> dict[str, float | None]:
    """``meanings`` of one recorded motion, in numbers; all None where it diverged.

    ``motion`` has ``error``, ``error_rate`` and ``command``, each (steps,); ``speed`` and
    ``commanded`` are the velocity that the axis has and the one it should have. "Once settled"
    means after ``settled_after`` [s], the same for every design; a loop that ends earlier is
    looked at as a whole. A loop that never settles has no settling time.
    """
    if not all(np.isfinite(part).all() for part in (motion.error, speed, motion.command)):
        return dict.fromkeys(meanings(drive))
    error = np.abs(motion.error)
    late = settled_samples(time, settled_after)
    stuck = is_stuck(speed, commanded)[late]
    large = np.flatnonzero(error > SETTLED * error.max())
    settled = 0 if len(large) == 0 else large[-1] + 1
    sample_time = time[1] - time[0] if len(time) > 1 else 0.0
    found = (
        np.sqrt(np.mean(error**2)),
        error.max(),
        np.sum(error) * sample_time,
        motion.error[-1],
        time[settled] if settled < len(time) else None,
        np.sqrt(np.mean(motion.error_rate[late] ** 2)),
        stuck.mean(),
        np.count_nonzero(stuck & ~np.concatenate([[False], stuck[:-1]])),
        np.abs(motion.command).max(),
        np.sum(motion.command**2) * sample_time,
    )
    values = (None if value is None else float(value) for value in found)
    return dict(zip(meanings(drive), values, strict=True))
