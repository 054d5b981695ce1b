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
#: A function of a ``Moment`` of one axis, or of its ``AxisRecord``.
Term: TypeAlias = Callable[[Any], Any]
#: On a path, a metric in a table is computed for each axis, for all axes, of which the worst
#: counts, or for the machine as a whole.
EACH, WORST, MACHINE = "each", "worst", "machine"
#: Tables of metrics: of axes that follow no path, of two axes on a path in X-Y, of a program.
ALONE, PLANE, PROGRAM = "alone", "plane", "program"


class Units(NamedTuple):
    """Units of the numbers of a machine."""

    signals: dict[str, str]  # ``Drive.units``
    millimetres: float | None  # length of a BLU [mm]


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
    limits: tuple[float, float]  # smallest and largest command

    @property
    def position(self) -> Floats:
        """Position (steps,)."""
        return self.reference - self.error

    @property
    def command_change(self) -> Floats:
        """Change (steps - 1,) of the command from sample to sample."""
        return np.diff(self.command)

    @property
    def finite(self) -> bool:
        """Whether all values are finite, that is, the motion did not diverge."""
        return all(np.isfinite(x).all() for x in (self.error, self.velocity, self.command))


class MotionRecord(NamedTuple):
    """The recorded motion of a machine, or of a part of it."""

    axes: tuple[AxisRecord, ...]
    contour: Contour | None  # None: the machine follows no path

    @property
    def finite(self) -> bool:
        """Whether all values are finite, that is, the motion did not diverge."""
        off = self.contour is None or bool(np.isfinite(self.contour.error).all())
        return off and all(axis.finite for axis in self.axes)


class Reduction(NamedTuple):
    """Functions that reduce the samples of a motion to one number, in a loop or from a record."""

    initial: Callable[[Scalar], Sums]
    update: Callable[[Sums, Moments, PathFrame | None], Sums]
    value: Callable[[Sums], Scalar]
    recorded: Callable[[AxisRecord], float | None] | None = None


def _not_running(*_: Any) -> Any:
    raise TypeError("this metric is computed from recorded motions only")


class Metric(NamedTuple):
    """A number of a motion as pure functions, similar to an ``Objective``.

    ``initial``, ``update`` and ``value`` compute it while a loop runs; without them a scenario
    cannot name it. With several axes it is then the rms of their vector, or their largest value,
    sum or mean. ``recorded`` computes it from the ``AxisRecord`` of an axis, or with the scope
    ``MACHINE`` from a ``MotionRecord``; None: it does not exist in that motion.
    """

    name: str
    unit: str  # a unit, or the name of a signal of the drive, such as "error", for its unit
    meaning: str  # tables replace the word "command" by the drive's name for its command
    initial: Callable[[Scalar], Sums] = _not_running
    update: Callable[[Sums, Moments, PathFrame | None], Sums] = _not_running
    value: Callable[[Sums], Scalar] = _not_running
    recorded: Callable[[Any], float | None] | None = None
    tables: tuple[str, ...] = ()  # tables in which it is a column
    rank: int = 0  # its position in comparisons; 0: it is not compared
    scope: str = EACH  # what ``recorded`` is computed for: ``EACH``, ``WORST`` or ``MACHINE``
    key: str = ""  # key of its column; "": its name followed by its unit
    exists: Callable[[Sequence[Drive]], bool] | None = None  # with these drives; None: always
    path: bool = False  # whether it needs a machine that follows a path
    doubled: bool = False  # whether it needs a copy of the machine with a disturbed start
    directions: int = 0  # of a circle: so many directions in which it needs a full turn

    @property
    def running(self) -> bool:
        """Whether it can be computed while a loop runs."""
        return self.update is not _not_running

    @property
    def wordless(self) -> "Metric":
        """The metric without its texts, as a loop needs it."""
        loop = (self.initial, self.update, self.value)
        return Metric("", "", "", *loop, path=self.path, doubled=self.doubled)


def _everywhere(moment: Moment) -> Scalar:
    return 1.0


def rms(term: Term, when: Term | None = None) -> Reduction:
    """Reduce to the rms of ``term`` where ``when`` is 1; in a loop, of the vector of all axes."""
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
    """Reduce to the largest magnitude of ``term`` where ``when`` is 1; in a loop, of all axes."""

    def update(sums: Sums, moments: Moments, path: PathFrame | None) -> Sums:
        return reduce(jnp.maximum, [when(x) * jnp.abs(term(x)) for x in moments], sums)

    def recorded(axis: AxisRecord) -> float | None:
        return float((when(axis) * np.abs(term(axis))).max())

    return Reduction(lambda zero: zero, update, lambda sums: sums, recorded)


def share(truth: Term, when: Term) -> Reduction:
    """Reduce to the share of the samples with ``when`` = 1 for which ``truth`` holds; none: 0."""

    def update(sums: Sums, moments: Moments, path: PathFrame | None) -> Sums:
        hits = reduce(jnp.add, [jnp.where(truth(x), when(x), 0.0) for x in moments])
        return sums[0] + hits, sums[1] + reduce(jnp.add, [when(x) for x in moments])

    def value(sums: Sums) -> Scalar:
        return sums[0] / jnp.maximum(sums[1], 1.0)

    return Reduction(lambda zero: (zero, zero), update, value)


def integral(term: Term) -> Reduction:
    """Reduce to the integral of the magnitude of ``term`` over time; in a loop, of all axes."""

    def update(sums: Sums, moments: Moments, path: PathFrame | None) -> Sums:
        return sums + moments[0].sample_time * reduce(jnp.add, [jnp.abs(term(x)) for x in moments])

    def recorded(axis: AxisRecord) -> float | None:
        return float(np.sum(np.abs(term(axis))) * sample_time(axis))

    return Reduction(lambda zero: zero, update, lambda sums: sums, recorded)


def sample_time(axis: AxisRecord) -> float:
    """Return the time between two samples of a record [s]; 0 if there is only one sample."""
    return float(axis.time[1] - axis.time[0]) if len(axis.time) > 1 else 0.0


def in_units(key: str, quantity: float | str, unit: str, units: Units) -> float:
    """Return the value at ``key`` of a file as a number in the machine's ``unit`` of a metric.

    Raises:
        ValueError: it has a unit of another quantity.
    """
    words = [units.signals.get(word, word) for word in unit.split(" ")]
    try:
        return number(quantity, " ".join(words), units.millimetres)
    except ValueError as error:
        raise ValueError(f"{key} = {quantity!r}: {str(error).partition(': ')[2]}") from None


def path_fault(metrics: Sequence[Metric], path: bool) -> str | None:
    """Return the error line if one of ``metrics`` needs a path and the machine follows none."""
    names = [one.name for one in metrics if one.path and not path]
    return f"{names[0]}: needs a machine that follows a path" if names else None
