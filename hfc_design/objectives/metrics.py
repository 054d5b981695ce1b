"""Every metric, one entry each, in the order of the tables; scenarios name them.

A new metric is an entry of ``METRICS`` and nothing else.
"""

from collections.abc import Callable, Sequence
from functools import cache, partial, reduce
from operator import attrgetter
from typing import Any

import jax.numpy as jnp
import numpy as np
from jax.tree_util import Partial

from hfc_design.core import numbers
from hfc_design.core.numbers import Floats, Scalar, Truth
from hfc_design.core.wording import one_of
from hfc_design.motion.circularity import minimum_zone
from hfc_design.motion.contour import Contour, off_path
from hfc_design.motion.reversals import GLITCH_TIME
from hfc_design.motion.samples import PathFrame
from hfc_design.objectives import recorded
from hfc_design.objectives.metric import (
    ALONE,
    MACHINE,
    PLANE,
    PROGRAM,
    WORST,
    Metric,
    Moments,
    MotionRecord,
    Reduction,
    integral,
    largest,
    rms,
    sample_time,
    share,
)
from hfc_design.objectives.objective import Moment, Sums
from hfc_design.objectives.stick_share import is_stuck
from hfc_design.objectives.unsettled import unsettled
from plants import Drive

#: Name of the metric that needs a band of the error.
BAND_TIME = "band_time"
#: Prefix of the metrics of the contour error that are summed while a loop runs: they measure it
#: from the commanded point; the metrics of the tables, from the nearest point of the path.
ESTIMATED = "estimated_"
AXIS, PATH, EVERY = (ALONE,), (PLANE, PROGRAM), (ALONE, PLANE, PROGRAM)

_error, _rate, _command = attrgetter("error"), attrgetter("error_rate"), attrgetter("command")
_change, _settled = attrgetter("command_change"), attrgetter("settled")
_beyond, _limited, _sliding = attrgetter("beyond"), attrgetter("limited"), attrgetter("sliding")


def _late(moment: Moment) -> Scalar:
    return jnp.where(moment.late > 0, 1.0, 0.0)


def _stuck(moment: Moment) -> Truth:
    """Return whether an axis is stuck, by its mean velocity, which leaves out trembling."""
    return is_stuck(moment.velocity, moment.reference_rate)


def _linear(drives: Sequence[Drive]) -> bool:
    return any(drive.millimetres is not None for drive in drives)


def _rotary(drives: Sequence[Drive]) -> bool:
    return any(drive.millimetres is None for drive in drives)


def _two_encoders(drives: Sequence[Drive]) -> bool:
    return any(drive.off_its_position for drive in drives)


def _estimated(
    name: str,
    meaning: str,
    reduction: Reduction,
    rank: int,
    where: Callable[[PathFrame], Scalar] | None = None,
) -> Metric:
    """Return a metric of the estimated contour error, multiplied by ``where`` (0 or 1)."""

    def update(sums: Sums, moments: Moments, path: PathFrame | None) -> Sums:
        assert path is not None  # this metric exists on paths only
        off = off_path(path, [moment.deviation for moment in moments]).contour
        off = off if where is None else where(path) * off
        return reduction.update(sums, (moments[0]._replace(error=off),), None)

    running = reduction._replace(update=update, recorded=None)
    text = meaning.format("estimated contour error")
    return Metric(ESTIMATED + name, "error", text, *running, path=True, rank=rank)


def _contour(
    name: str,
    meaning: str,
    rank: int,
    error: Callable[[Contour], Floats | None],
    reduced: Callable[[Floats], float] = recorded.largest,
    tables: tuple[str, ...] = PATH,
    exists: Callable[[Sequence[Drive]], bool] = _linear,
    unit: str = "length",
) -> Metric:
    """Return a metric of a whole machine on a path: ``reduced`` of the ``error`` (steps,)."""

    def read(motion: MotionRecord) -> float | None:
        assert motion.contour is not None
        errors = error(motion.contour)
        return None if errors is None or not len(errors) else float(reduced(errors))

    parts: Any = {"recorded": read, "tables": tables, "rank": rank, "scope": MACHINE}
    return Metric(name, unit, meaning, **parts, exists=exists)


def _circle(
    name: str, meaning: str, rank: int, reduce_turns: Callable[..., Any], directions: int = 1
) -> Metric:
    """Return a metric: a function of full turns of a circle, in ``directions``, and its radius."""
    read = partial(recorded.circular, reduce_turns, directions)
    return _contour(name, meaning, rank, read, tables=(PLANE,))._replace(directions=directions)


def _orientation(name: str, meaning: str, *of: Any) -> Metric:
    parts: Any = {"tables": (PROGRAM,), "exists": _rotary, "unit": "deg"}
    return _contour(name, meaning, 5, *of, **parts)


def _axis(
    name: str, unit: str, meaning: str, read: Callable[[Any], float | None], rank: int = 0
) -> Metric:
    """Return a metric of the recorded motion of one axis that follows no path."""
    return Metric(name, unit, meaning, recorded=read, tables=AXIS, rank=rank)


METRICS: tuple[Metric, ...] = (
    _contour(
        "rms_contour_error",
        "root mean square of the contour error",
        1,
        attrgetter("error"),
        numbers.rms,
    ),
    _contour("max_contour_error", "largest contour error", 2, attrgetter("error")),
    _contour(
        "cutting_max_contour_error",
        "the same without rapids, G0",
        2,
        recorded.cutting,
        tables=(PROGRAM,),
    ),
    _contour(
        "worst_glitch",
        "largest contour error after a linear axis reverses",
        3,
        lambda off: recorded.after(off.glitches),
    ),
    _contour(
        "path_error",
        f"largest contour error except within {GLITCH_TIME:g} s after an axis starts or reverses",
        4,
        lambda off: off.error[off.undisturbed],
    ),
    _circle(
        "circular_deviation",
        "circular deviation G of a full turn (ISO 230-4)",
        4,
        lambda turns, radius: [*map(minimum_zone, turns)],
    ),
    _circle(
        "bidirectional_circular_deviation",
        "circular deviation G(b) of both directions together (ISO 230-4)",
        4,
        lambda turns, radius: [minimum_zone(np.concatenate(turns, axis=1))],
        2,
    ),
    _circle(
        "radial_deviation",
        "largest radial deviation F of a full turn (ISO 230-4)",
        0,
        lambda turns, radius: np.hypot(*np.concatenate(turns, axis=1)) - radius,
    ),
    _contour(
        "known_rms_contour_error",
        "root mean square of the contour error, by the feedback encoders",
        1,
        attrgetter("known"),
        numbers.rms,
        (PLANE,),
        _two_encoders,
    ),
    _contour(
        "known_max_contour_error",
        "largest of these",
        2,
        attrgetter("known"),
        tables=(PLANE,),
        exists=_two_encoders,
    ),
    _orientation(
        "rms_orientation_error",
        "root mean square of the error of the orientation",
        attrgetter("turned"),
        numbers.rms,
    ),
    _orientation("max_orientation_error", "largest error of the orientation", attrgetter("turned")),
    _orientation(
        "worst_orientation_glitch",
        "the same after a rotary axis reverses",
        lambda off: recorded.after(off.turned_glitches),
    ),
    Metric("rms_error", "error", "root mean square of the tracking error", *rms(_error), EVERY, 6),
    Metric("max_error", "error", "largest tracking error", *largest(_error), EVERY, 7),
    Metric(
        "settled_rms_error",
        "error",
        "rms of the tracking error once settled",
        *rms(_error, _settled),
        rank=6,
    ),
    Metric(
        "settled_max_error",
        "error",
        "largest tracking error once settled",
        *largest(_error, _settled),
        rank=7,
    ),
    Metric(
        "iae",
        "error s",
        "integral of the tracking error's magnitude",
        *integral(_error),
        AXIS,
        key="iae_{error}_s",
    ),
    _axis(
        "final_error", "error", "tracking error at the last sample", lambda x: float(x.error[-1])
    ),
    _axis(
        "settling_time",
        "s",
        "from then on the error stays below a tenth of its maximum",
        recorded.settling_time,
        9,
    ),
    _estimated("rms_contour_error", "root mean square of the {}", rms(_error), 1),
    _estimated("max_contour_error", "largest {}", largest(_error), 2),
    _estimated(
        "path_error",
        "largest {} away from starts and reversals",
        largest(_error),
        4,
        lambda path: path.undisturbed,
    ),
    _estimated(
        "worst_glitch",
        "largest {} after an axis reverses",
        largest(_error),
        3,
        lambda path: path.reversing,
    ),
    Metric(
        "overshoot", "error", "how far the axis goes beyond its goal", *largest(_beyond), rank=8
    ),
    Metric(
        "overshoot",
        "error",
        "how far beyond a reversal or the end of the program",
        recorded=lambda axis: recorded.overshoot(axis.reference, axis.position),
        tables=(PROGRAM,),
        rank=8,
    ),
    Metric(
        "velocity_ripple",
        "error_rate",
        "rms of the velocity error once settled",
        *rms(_rate, _settled),
        AXIS,
    ),
    _axis(
        "stick_share",
        "1",
        "share of the time, once settled, below a tenth of the commanded speed",
        lambda axis: float(recorded.stands(axis).mean()),
        12,
    ),
    _axis("stick_events", "1", "how often the axis stuck, once settled", recorded.stick_events),
    Metric(
        "peak_command", "command", "largest command", *largest(_command), EVERY, 11, scope=WORST
    ),
    _axis(
        "control_effort",
        "command2 s",
        "integral of the squared command",
        lambda axis: float(np.sum(axis.command**2) * sample_time(axis)),
    ),
    Metric(
        "chatter",
        "command",
        "root mean square of the change of the command from sample to sample",
        *rms(_change),
        EVERY,
        10,
        scope=WORST,
        key="rms_command_change",
    ),
    Metric("rms_command", "command", "root mean square of the command", *rms(_command)),
    Metric(
        "stick_slip",
        "1",
        "share of the sliding time in which the axis stands",
        *share(_stuck, _sliding),
    ),
    Metric(
        "velocity_share",
        "1",
        "largest velocity of an axis, of its limit",
        recorded=recorded.velocity_share,
        tables=(PROGRAM,),
        scope=MACHINE,
    ),
    Metric(
        "limit_share",
        "1",
        "share of the time in which a command is at its limit",
        recorded=recorded.limited,
        tables=(PROGRAM,),
        scope=MACHINE,
    ),
    Metric(
        "limit_share",
        "1",
        "share of the last quarter at a limit of the command",
        *share(_limited, _late),
    ),
    Metric(
        "late_error", "error", "largest tracking error in the last quarter", *largest(_error, _late)
    ),
    Metric(
        "unsettled",
        "1",
        "share of a small disturbance of the start that still oscillates in the end",
        *unsettled(),
        doubled=True,
    ),
)
#: Metrics that a scenario can name, except ``band_time``, which depends on its band.
RUNNING: dict[str, Metric] = {one.name: one for one in METRICS if one.running}


def band_time(band: float) -> Metric:
    """Return the metric: time from which the error stays within a ``band`` [unit of the error]."""
    meaning = f"from then on the error stays within {band:g}"
    return Metric(BAND_TIME, "s", meaning, _same, Partial(_left, band), _same)


def _same(zero: Scalar) -> Scalar:
    return zero


def _left(band: Scalar, sums: Sums, moments: Moments, path: PathFrame | None) -> Sums:
    off = reduce(jnp.maximum, [jnp.abs(x.error) for x in moments])
    return jnp.where(off > band, moments[0].time + moments[0].sample_time, sums)


def named(name: str) -> str:
    """Return the name of a metric; some names in files of version 0.1 lack "estimated_"."""
    return ESTIMATED + name if ESTIMATED + name in RUNNING else name


@cache
def metric(name: str, band: Any = None) -> Metric:
    """Return the metric that a scenario names; ``band``: for ``band_time``; ValueError: unknown."""
    if name == BAND_TIME:
        return band_time(0.0 if band is None else band)
    if name not in RUNNING:
        known = one_of(name, [*RUNNING, BAND_TIME])
        raise ValueError(f"{name}: unknown metric; {known}; see hfc show metric")
    return RUNNING[name]
