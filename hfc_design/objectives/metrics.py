"""Every metric, one entry each, in the order of the tables; scenarios name them.

A new metric is an entry of ``METRICS`` and nothing else.
"""

import re
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
_known, _turned = attrgetter("known"), attrgetter("turned")
_undisturbed, _reversing = attrgetter("undisturbed"), attrgetter("reversing")


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


def _metric(rank: int, title: str, *reduction: Any, **more: Any) -> Metric:
    """Return a metric with a ``title`` like "name [unit]: meaning"."""
    name, unit, meaning = re.split(r" \[|\]: ", title, maxsplit=2)
    return Metric(name, unit, meaning, *reduction)._replace(rank=rank, **more)


def _estimated(
    rank: int, title: str, reduction: Reduction, where: Callable[[PathFrame], Scalar] | None = None
) -> Metric:
    """Return a metric of the estimated contour error, multiplied by ``where`` (0 or 1)."""

    def update(sums: Sums, moments: Moments, path: PathFrame | None) -> Sums:
        assert path is not None  # this metric exists on paths only
        off = off_path(path, [moment.deviation for moment in moments]).contour
        off = off if where is None else where(path) * off
        return reduction.update(sums, (moments[0]._replace(error=off),), None)

    running = reduction._replace(update=update, recorded=None)
    return _metric(rank, ESTIMATED + title, *running, path=True)


def _contour(
    rank: int,
    title: str,
    error: Callable[[Contour], Floats | None],
    reduced: Callable[[Floats], float] = recorded.largest,
    tables: tuple[str, ...] = PATH,
    exists: Callable[[Sequence[Drive]], bool] = _linear,
) -> Metric:
    """Return a metric of a whole machine on a path: ``reduced`` of the ``error`` (steps,)."""

    def read(motion: MotionRecord) -> float | None:
        assert motion.contour is not None
        errors = error(motion.contour)
        return None if errors is None or not len(errors) else float(reduced(errors))

    return _metric(rank, title, recorded=read, tables=tables, scope=MACHINE, exists=exists)


#: Metrics of the orientation, and of the contour error by the encoders that are fed back.
_orientation = partial(_contour, tables=(PROGRAM,), exists=_rotary)
_fed_back = partial(_contour, tables=(PLANE,), exists=_two_encoders)


def _circle(rank: int, title: str, reduce_turns: Callable[..., Any], directions: int = 1) -> Metric:
    """Return a metric: a function of full turns of a circle, in ``directions``, and its radius."""
    read = partial(recorded.circular, reduce_turns, directions)
    return _contour(rank, title, read, tables=(PLANE,))._replace(directions=directions)


def _axis(rank: int, title: str, read: Callable[[Any], float | None]) -> Metric:
    """Return a metric of the recorded motion of one axis that follows no path."""
    return _metric(rank, title, recorded=read, tables=AXIS)


METRICS: tuple[Metric, ...] = (
    _contour(
        1, "rms_contour_error [length]: root mean square of the contour error", _error, numbers.rms
    ),
    _contour(2, "max_contour_error [length]: largest contour error", _error),
    _contour(
        2,
        "cutting_max_contour_error [length]: the same without rapids, G0",
        recorded.cutting,
        tables=(PROGRAM,),
    ),
    _contour(
        3,
        "worst_glitch [length]: largest contour error after a linear axis reverses",
        lambda off: recorded.after(off.glitches),
    ),
    _contour(
        4,
        f"path_error [length]: largest contour error except within {GLITCH_TIME:g} s after an axis "
        "starts or reverses",
        lambda off: off.error[off.undisturbed],
    ),
    _circle(
        4,
        "circular_deviation [length]: circular deviation G of a full turn (ISO 230-4)",
        lambda turns, radius: [*map(minimum_zone, turns)],
    ),
    _circle(
        4,
        "bidirectional_circular_deviation [length]: circular deviation G(b) of both directions "
        "together (ISO 230-4)",
        lambda turns, radius: [minimum_zone(np.concatenate(turns, axis=1))],
        2,
    ),
    _circle(
        0,
        "radial_deviation [length]: largest radial deviation F of a full turn (ISO 230-4)",
        lambda turns, radius: np.hypot(*np.concatenate(turns, axis=1)) - radius,
    ),
    _fed_back(
        1,
        "known_rms_contour_error [length]: root mean square of the contour error, by the feedback "
        "encoders",
        _known,
        numbers.rms,
    ),
    _fed_back(2, "known_max_contour_error [length]: largest of these", _known),
    _orientation(
        5,
        "rms_orientation_error [deg]: root mean square of the error of the orientation",
        _turned,
        numbers.rms,
    ),
    _orientation(5, "max_orientation_error [deg]: largest error of the orientation", _turned),
    _orientation(
        5,
        "worst_orientation_glitch [deg]: the same after a rotary axis reverses",
        lambda off: recorded.after(off.turned_glitches),
    ),
    _metric(6, "rms_error [error]: root mean square of the tracking error", *rms(_error), EVERY),
    _metric(7, "max_error [error]: largest tracking error", *largest(_error), EVERY),
    _metric(
        6,
        "settled_rms_error [error]: rms of the tracking error once settled",
        *rms(_error, _settled),
    ),
    _metric(
        7,
        "settled_max_error [error]: largest tracking error once settled",
        *largest(_error, _settled),
    ),
    _metric(
        0,
        "iae [error s]: integral of the tracking error's magnitude",
        *integral(_error),
        AXIS,
        key="iae_{error}_s",
    ),
    _axis(
        0, "final_error [error]: tracking error at the last sample", lambda x: float(x.error[-1])
    ),
    _axis(
        9,
        "settling_time [s]: from then on the error stays below a tenth of its maximum",
        recorded.settling_time,
    ),
    _estimated(
        1, "rms_contour_error [error]: root mean square of the estimated contour error", rms(_error)
    ),
    _estimated(2, "max_contour_error [error]: largest estimated contour error", largest(_error)),
    _estimated(
        4,
        "path_error [error]: largest estimated contour error away from starts and reversals",
        largest(_error),
        _undisturbed,
    ),
    _estimated(
        3,
        "worst_glitch [error]: largest estimated contour error after an axis reverses",
        largest(_error),
        _reversing,
    ),
    _metric(8, "overshoot [error]: how far the axis goes beyond its goal", *largest(_beyond)),
    _metric(
        8,
        "overshoot [error]: how far beyond a reversal or the end of the program",
        recorded=lambda axis: recorded.overshoot(axis.reference, axis.position),
        tables=(PROGRAM,),
    ),
    _metric(
        0,
        "velocity_ripple [error_rate]: rms of the velocity error once settled",
        *rms(_rate, _settled),
        AXIS,
    ),
    _axis(
        12,
        "stick_share [1]: share of the time, once settled, below a tenth of the commanded speed",
        lambda axis: float(recorded.stands(axis).mean()),
    ),
    _axis(0, "stick_events [1]: how often the axis stuck, once settled", recorded.stick_events),
    _metric(11, "peak_command [command]: largest command", *largest(_command), EVERY, scope=WORST),
    _axis(
        0,
        "control_effort [command2 s]: integral of the squared command",
        lambda axis: float(np.sum(axis.command**2) * sample_time(axis)),
    ),
    _metric(
        10,
        "chatter [command]: root mean square of the change of the command from sample to sample",
        *rms(_change),
        EVERY,
        scope=WORST,
        key="rms_command_change",
    ),
    _metric(0, "rms_command [command]: root mean square of the command", *rms(_command)),
    _metric(
        0,
        "stick_slip [1]: share of the sliding time in which the axis stands",
        *share(_stuck, _sliding),
    ),
    _metric(
        0,
        "velocity_share [1]: largest velocity of an axis, of its limit",
        recorded=recorded.velocity_share,
        tables=(PROGRAM,),
        scope=MACHINE,
    ),
    _metric(
        0,
        "limit_share [1]: share of the time in which a command is at its limit",
        recorded=recorded.limited,
        tables=(PROGRAM,),
        scope=MACHINE,
    ),
    _metric(
        0,
        "limit_share [1]: share of the last quarter at a limit of the command",
        *share(_limited, _late),
    ),
    _metric(
        0, "late_error [error]: largest tracking error in the last quarter", *largest(_error, _late)
    ),
    _metric(
        0,
        "unsettled [1]: share of a small disturbance of the start that still oscillates in the end",
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
