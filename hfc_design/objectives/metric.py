"""Metrics: numbers of a motion, the smaller in magnitude the better.

A metric that is summed sample by sample inside the loop costs the same for a population of
thousands as for one, and scenarios can name it: as a target, a constraint or a goal. A metric
that is computed from a recorded motion is a column of the tables of ``hfc score`` and
``hfc compare``. Most metrics are both.
"""

from collections.abc import Callable, Sequence
from functools import reduce
from typing import Any, NamedTuple, TypeAlias

import jax.numpy as jnp
import numpy as np

from hfc_design.core.numbers import Floats, Mask, Scalar
from hfc_design.core.quantities import number
from hfc_design.motion.contour import Contour
from hfc_design.motion.samples import PathFrame
from hfc_design.objectives.objective import Moment, Sums
from plants import Drive

Moments: TypeAlias = tuple[Moment, ...]
#: Of a ``Moment`` of one axis, or of its ``AxisRecord``.
Term: TypeAlias = Callable[[Any], Any]
#: Whose recorded motion a metric is computed from: each axis, every axis of which the worst one
#: counts, or the machine as a whole.
EACH, WORST, MACHINE = "each", "worst", "machine"
#: Tables, by what a machine follows: its axes no path, two of them a path in X-Y, or a program.
ALONE, PLANE, PROGRAM = "alone", "plane", "program"


class Units(NamedTuple):
    """Units of the numbers of a machine."""

    signals: dict[str, str]  # ``Drive.units``
    millimetres: float | None  # of a BLU


class AxisRecord(NamedTuple):
    """The recorded motion of one axis: arrays (steps,) in the units of its drive."""

    name: str
    drive: Drive
    time: Floats  # [s]
    settled: Mask  # samples at which the loop should have settled
    reference: Floats
    reference_rate: Floats
    error: Floats
    error_rate: Floats
    velocity: Floats
    command: Floats
    limits: tuple[float, float]  # of the command

    @property
    def position(self) -> Floats:
        """(steps,) position."""
        return self.reference - self.error

    @property
    def command_change(self) -> Floats:
        """(steps - 1,) change of the command from sample to sample."""
        return np.diff(self.command)

    @property
    def finite(self) -> bool:
        """Whether all values are finite, that is, the motion did not diverge."""
        return all(np.isfinite(x).all() for x in (self.error, self.velocity, self.command))


class MotionRecord(NamedTuple):
    """The recorded motion of a machine, or of a part of it."""

    axes: tuple[AxisRecord, ...]
    contour: Contour | None  # None: it follows no path

    @property
    def finite(self) -> bool:
        """Whether all values are finite, that is, the motion did not diverge."""
        off = self.contour is None or bool(np.isfinite(self.contour.error).all())
        return off and all(axis.finite for axis in self.axes)


class Reduction(NamedTuple):
    """Reduction of the samples of a motion to one number: running, or from a record."""

    initial: Callable[[Scalar], Sums]
    update: Callable[[Sums, Moments, PathFrame | None], Sums]
    value: Callable[[Sums], Scalar]
    recorded: Callable[[AxisRecord], float | None] | None = None


def _not_running(*_: Any) -> Any:
    raise TypeError("this metric is computed from recorded motions only")


class Metric(NamedTuple):
    """A number of a motion as pure functions, similar to an ``Objective``.

    ``initial``, ``update`` and ``value`` sum it while a loop runs; without them a scenario cannot
    name it. With several axes, errors and commands are then reduced as vectors and times as means.
    ``recorded`` computes it from an ``AxisRecord``, or as a metric of the whole ``MACHINE`` from a
    ``MotionRecord``; None: it does not exist in that motion.
    """

    name: str
    unit: str  # "error" say: that of the drive's signal of this name, or a unit
    meaning: str  # the word "command" in it gives way to what the drive calls its command
    initial: Callable[[Scalar], Sums] = _not_running
    update: Callable[[Sums, Moments, PathFrame | None], Sums] = _not_running
    value: Callable[[Sums], Scalar] = _not_running
    recorded: Callable[[Any], float | None] | None = None
    tables: tuple[str, ...] = ()  # in which it is a column
    rank: int = 0  # its place in comparisons; 0: it is not compared
    scope: str = EACH  # of ``recorded``
    key: str = ""  # of its column; "": its name, with its unit behind
    exists: Callable[[Sequence[Drive]], bool] | None = None  # on a machine of these; None: always
    path: bool = False  # only of a machine on a path
    doubled: bool = False  # of a copy of the machine too, that began a little off

    @property
    def running(self) -> bool:
        """Whether it can be summed while a loop runs."""
        return self.update is not _not_running

    @property
    def wordless(self) -> "Metric":
        """The metric without texts for people, as a loop computes it."""
        loop = (self.initial, self.update, self.value)
        return Metric("", "", "", *loop, path=self.path, doubled=self.doubled)


def _everywhere(moment: Moment) -> Scalar:
    return 1.0


def rms(term: Term, when: Term | None = None) -> Reduction:
    """Root mean square; of the vector of all axes while a loop runs."""
    weigh = when or _everywhere

    def update(sums: Sums, moments: Moments, path: PathFrame | None) -> Sums:
        weight = weigh(moments[0])
        squares = reduce(jnp.add, [jnp.square(term(moment)) for moment in moments])
        return sums[0] + weight * squares, sums[1] + weight

    def value(sums: Sums) -> Scalar:
        return jnp.sqrt(sums[0] / jnp.maximum(sums[1], 1.0))

    def recorded(axis: AxisRecord) -> float | None:
        values = term(axis) if when is None else term(axis)[when(axis)]
        return float(np.sqrt(np.mean(values**2))) if len(values) else None

    return Reduction(lambda zero: (zero, zero), update, value, recorded)


def largest(term: Term, when: Term = _everywhere) -> Reduction:
    """Largest magnitude of any axis."""

    def update(sums: Sums, moments: Moments, path: PathFrame | None) -> Sums:
        return reduce(jnp.maximum, [when(x) * jnp.abs(term(x)) for x in moments], sums)

    def recorded(axis: AxisRecord) -> float | None:
        return float((when(axis) * np.abs(term(axis))).max())

    return Reduction(lambda zero: zero, update, lambda sums: sums, recorded)


def share(truth: Term, when: Term) -> Reduction:
    """Share of the counted samples for which a condition is true; 0 if none is counted."""

    def update(sums: Sums, moments: Moments, path: PathFrame | None) -> Sums:
        hits = reduce(jnp.add, [jnp.where(truth(x), when(x), 0.0) for x in moments])
        return sums[0] + hits, sums[1] + reduce(jnp.add, [when(x) for x in moments])

    def value(sums: Sums) -> Scalar:
        return sums[0] / jnp.maximum(sums[1], 1.0)

    return Reduction(lambda zero: (zero, zero), update, value)


def integral(term: Term) -> Reduction:
    """Integral of the magnitude over time."""

    def update(sums: Sums, moments: Moments, path: PathFrame | None) -> Sums:
        return sums + moments[0].sample_time * reduce(jnp.add, [jnp.abs(term(x)) for x in moments])

    def recorded(axis: AxisRecord) -> float | None:
        return float(np.sum(np.abs(term(axis))) * sample_time(axis))

    return Reduction(lambda zero: zero, update, lambda sums: sums, recorded)


def sample_time(axis: AxisRecord) -> float:
    """Time between two samples of a record [s]; 0 if there is only one."""
    return float(axis.time[1] - axis.time[0]) if len(axis.time) > 1 else 0.0


def in_units(key: str, quantity: float | str, unit: str, units: Units) -> float:
    """Convert a quantity of a file to a number in the machine's ``unit`` of a metric.

    Raises:
        ValueError: its unit measures something else.
    """
    words = [units.signals.get(word, word) for word in unit.split(" ")]
    try:
        return number(quantity, " ".join(words), units.millimetres)
    except ValueError as error:
        raise ValueError(f"{key} = {quantity!r}: {str(error).partition(': ')[2]}") from None


def path_fault(metrics: Sequence[Metric], path: bool) -> str | None:
    """Error line if one of ``metrics`` is measured along a path, and the machine follows none."""
    names = [one.name for one in metrics if one.path and not path]
    return f"{names[0]}: needs a machine that follows a path" if names else None
