"""What is measured on a motion while it runs, by name: the smaller, the better.

Every measure adds up sample by sample inside the loop, so that it costs the same for a population
of thousands as for one. Of several axes errors and commands count as vectors, times as means.
"""

from collections.abc import Callable, Sequence
from functools import cache, reduce
from operator import attrgetter
from typing import Any, NamedTuple, TypeAlias

import jax.numpy as jnp
from jax.tree_util import Partial

from hfc_design.core.numbers import Scalar, Truth
from hfc_design.core.quantities import number
from hfc_design.core.wording import one_of
from hfc_design.motion.contour import off_path
from hfc_design.motion.samples import PathFrame
from hfc_design.objectives.objective import Moment, Sums
from hfc_design.objectives.stick_share import is_stuck

Moments: TypeAlias = tuple[Moment, ...]
Term: TypeAlias = Callable[[Moment], Scalar]
#: The measure that needs a band of the error.
BAND_TIME = "band_time"
#: What grows within the last quarter counts by no more than this factor.
MOST_GROWTH = 10.0
#: Samples of the control in which what oscillates fast goes about as far as its amplitude.
SWING = 10.0


class Units(NamedTuple):
    """What the numbers of a machine count in."""

    signals: dict[str, str]  # ``Drive.units``
    millimetres: float | None  # of a BLU


class Measure(NamedTuple):
    """A number of a motion as pure functions of scalars, much as an ``Objective`` is one."""

    name: str
    unit: str  # what the drive calls it, "error" say, or a unit
    meaning: str
    initial: Callable[[Scalar], Sums]
    update: Callable[[Sums, Moments, PathFrame | None], Sums]
    value: Callable[[Sums], Scalar]
    path: bool = False  # only of a machine on a path
    doubled: bool = False  # of a copy of the machine too, that began a little off

    @property
    def wordless(self) -> "Measure":
        """What is computed of it, without what people read."""
        return self._replace(name="", unit="", meaning="")


def _always(moment: Moment) -> Scalar:
    return 1.0


def _settled(moment: Moment) -> Scalar:
    return moment.settled


def _at_the_end(moment: Moment) -> Scalar:
    return jnp.where(moment.late > 0, 1.0, 0.0)


def rms(name: str, unit: str, meaning: str, term: Term, when: Term = _always) -> Measure:
    """Root mean square of the vector of all axes."""

    def update(sums: Sums, moments: Moments, path: PathFrame | None) -> Sums:
        weight = when(moments[0])
        squares = reduce(jnp.add, [jnp.square(term(moment)) for moment in moments])
        return sums[0] + weight * squares, sums[1] + weight

    def value(sums: Sums) -> Scalar:
        return jnp.sqrt(sums[0] / jnp.maximum(sums[1], 1.0))

    return Measure(name, unit, meaning, lambda zero: (zero, zero), update, value)


def largest(name: str, unit: str, meaning: str, term: Term, when: Term = _always) -> Measure:
    """Largest magnitude of any axis."""

    def update(sums: Sums, moments: Moments, path: PathFrame | None) -> Sums:
        return reduce(jnp.maximum, [when(x) * jnp.abs(term(x)) for x in moments], sums)

    return Measure(name, unit, meaning, lambda zero: zero, update, lambda sums: sums)


def share(name: str, meaning: str, truth: Term, when: Term) -> Measure:
    """Share of the samples that count in which something is true; 0 where none counts."""

    def update(sums: Sums, moments: Moments, path: PathFrame | None) -> Sums:
        hits = reduce(jnp.add, [jnp.where(truth(x), when(x), 0.0) for x in moments])
        return sums[0] + hits, sums[1] + reduce(jnp.add, [when(x) for x in moments])

    def value(sums: Sums) -> Scalar:
        return sums[0] / jnp.maximum(sums[1], 1.0)

    return Measure(name, "1", meaning, lambda zero: (zero, zero), update, value)


def _integral(name: str, unit: str, meaning: str, term: Term) -> Measure:
    def update(sums: Sums, moments: Moments, path: PathFrame | None) -> Sums:
        return sums + moments[0].sample_time * reduce(jnp.add, [jnp.abs(term(x)) for x in moments])

    return Measure(name, unit, meaning, lambda zero: zero, update, lambda sums: sums)


def _estimated(
    make: Callable[..., Measure],
    name: str,
    description: str,
    where: Callable[[PathFrame], Scalar] | None = None,
) -> Measure:
    """A measure of the contour error as the control can know it; ``where`` else than 1, of 0."""
    one = make(ESTIMATED + name, "error", description.format("estimated contour error"), _error)

    def update(sums: Sums, moments: Moments, path: PathFrame | None) -> Sums:
        assert path is not None  # it is measured on paths only
        off = off_path(path, [moment.deviation for moment in moments]).contour
        off = off if where is None else where(path) * off
        return one.update(sums, (moments[0]._replace(error=off),), None)

    return one._replace(update=update, path=True)


def band_time(band: float) -> Measure:
    """When the error last left a ``band`` [unit of the error] about the reference."""

    meaning = f"from then on the error stays within {band:g}"
    return Measure(BAND_TIME, "s", meaning, _same, Partial(_left, band), _same)


def _same(zero: Scalar) -> Scalar:
    return zero


def _left(band: Scalar, sums: Sums, moments: Moments, path: PathFrame | None) -> Sums:
    off = reduce(jnp.maximum, [jnp.abs(x.error) for x in moments])
    return jnp.where(off > band, moments[0].time + moments[0].sample_time, sums)


def _unsettled() -> Measure:
    """How much a copy of the loop that began a little off still oscillates against it in the end.

    What settles forgets how it began: both end on one motion, whatever vibration a load forces on
    them. Loops that oscillate by themselves do so each in its own phase. Friction may let the two
    rest at different places: what counts are the variances within each half of the last quarter, of
    the distance and of ``SWING`` samples times its rate (an amplitude, of what oscillates that
    fast; faster oscillation counts more). What grows counts by the factor by which it does, if it
    does so in the distance and in the rate: of a steady oscillation that is slower than a half, one
    of them has less in the second half whenever the other has more.
    """

    def update(sums: Sums, moments: Moments, path: PathFrame | None) -> Sums:
        time = SWING * moments[0].sample_time
        # Axes, as encoders, in unlike shares: what oscillates one against another does not cancel.
        apart = reduce(jnp.add, [x.apart / (1 + k) for k, x in enumerate(moments)])
        rate = reduce(jnp.add, [time * x.apart_rate / (1 + k) for k, x in enumerate(moments)])
        halves = []
        for half, (count, *each) in enumerate(sums, 1):
            here = jnp.where(moments[0].late == half, 1.0, 0.0)
            more = (apart, apart * apart, rate, rate * rate)
            halves.append((count + here, *(a + here * b for a, b in zip(each, more, strict=True))))
        return tuple(halves)

    def variances(sums: Sums) -> tuple[Scalar, Scalar]:
        """Of the distance and of the rate in a half."""
        count, *each = sums
        mean, square, mean_rate, square_rate = (one / jnp.maximum(count, 1.0) for one in each)
        estimates = square - mean * mean, square_rate - mean_rate * mean_rate
        return jnp.maximum(estimates[0], 0.0), jnp.maximum(estimates[1], 0.0)

    def growth(before: Scalar, after: Scalar) -> Scalar:
        least = after / MOST_GROWTH**2 + jnp.finfo(jnp.float32).tiny
        return after / jnp.maximum(before, least)

    def value(sums: Sums) -> Scalar:
        before, after = map(variances, sums)
        grown = jnp.minimum(*map(growth, before, after))
        return jnp.sqrt((after[0] + after[1]) * jnp.maximum(grown, 1.0))

    def empty(zero: Scalar) -> Sums:
        return (zero,) * 5, (zero,) * 5

    meaning = "share of a small disturbance of the start that still oscillates in the end"
    return Measure("unsettled", "1", meaning, empty, update, value, doubled=True)


def stuck(moment: Moment) -> Truth:
    """Whether an axis stands that should move, and does not only tremble."""
    return is_stuck(moment.velocity, moment.reference_rate)


_error, _command = attrgetter("error"), attrgetter("command")
_change, _sliding = attrgetter("command_change"), attrgetter("sliding")
#: Before the names of the four measures of it: what tables have without it is found afterwards, by
#: a search for the nearest point of the path.
ESTIMATED = "estimated_"
#: What a scenario can name; ``band_time`` is made of its band.
MEASURES: dict[str, Measure] = {
    one.name: one
    for one in (
        rms("rms_error", "error", "root mean square of the error", _error),
        largest("max_error", "error", "largest error", _error),
        rms("settled_rms_error", "error", "rms of the error once settled", _error, _settled),
        largest("settled_max_error", "error", "largest error once settled", _error, _settled),
        _integral("iae", "error s", "integral of the error's magnitude", _error),
        _estimated(rms, "rms_contour_error", "root mean square of the {}"),
        _estimated(largest, "max_contour_error", "largest {}"),
        _estimated(
            largest,
            "path_error",
            "largest {} away from starts and reversals",
            lambda path: path.undisturbed,
        ),
        _estimated(
            largest,
            "worst_glitch",
            "largest {} after an axis reverses",
            lambda path: path.reversing,
        ),
        largest("overshoot", "error", "how far the axis goes beyond its goal", lambda x: x.beyond),
        rms(
            "velocity_ripple",
            "error_rate",
            "rms of the velocity error once settled",
            attrgetter("error_rate"),
            _settled,
        ),
        rms("chatter", "command", "rms of the change of the command in a sample", _change),
        largest("peak_command", "command", "largest command", _command),
        rms("rms_command", "command", "root mean square of the command", _command),
        share("stick_slip", "share of the sliding time in which the axis stands", stuck, _sliding),
        share(
            "limit_share",
            "share of the last quarter at a limit of the command",
            attrgetter("limited"),
            _at_the_end,
        ),
        largest("late_error", "error", "largest error in the last quarter", _error, _at_the_end),
        _unsettled(),
    )
}


def named(name: str) -> str:
    """The name of a measure; files of version 0.1 have some without what says "estimated"."""
    return ESTIMATED + name if ESTIMATED + name in MEASURES else name


@cache
def measure(name: str, band: Any = None) -> Measure:
    """The measure with a name; ValueError: there is none, or it needs a ``band`` of the error."""
    if name == BAND_TIME:
        if band is None:
            return band_time(0.0)
        return band_time(band)
    if name not in MEASURES:
        known = one_of(name, [*MEASURES, BAND_TIME])
        raise ValueError(f"{name}: is no measure; {known}; all are told by hfc show metric")
    return MEASURES[name]


def in_units(key: str, quantity: float | str, unit: str, units: Units) -> float:
    """A quantity of a file as a number of the machine's ``unit`` of a measure.

    Raises:
        ValueError: it has a unit of something else.
    """
    words = [units.signals.get(word, word) for word in unit.split(" ")]
    try:
        return number(quantity, " ".join(words), units.millimetres)
    except ValueError as error:
        raise ValueError(f"{key} = {quantity!r}: {str(error).partition(': ')[2]}") from None


def path_fault(measures: Sequence[Measure], path: bool) -> str | None:
    """A line if one of ``measures`` is of a path, and the machine follows none."""
    names = [one.name for one in measures if one.path and not path]
    return f"{names[0]}: is of a machine that follows a path" if names else None
