"""A user's own control law whose gains are a few numbers. Never imports JAX."""

from collections.abc import Callable
from math import isfinite
from typing import Any, NamedTuple

from hfc_design.controllers.controller import AxisLaw, Signals
from hfc_design.core.scalars import Xp
from hfc_design.core.shapes import Scalar

Range = tuple[float, float]


class Law(NamedTuple):
    """A control law as pure functions of scalars, and where its gains are searched::

        memory = law.initial_memory(0.0)
        command, memory = law.step(sample_time, gains, memory, signals)

    ``ranges`` is a NamedTuple of (low, high), ``gains`` one of the same class with numbers. A
    range above zero is searched by its logarithm, any other one on a straight line. ``signals``
    holds ``error``, ``error_rate`` and the plant's readings.
    """

    name: str  # the ``kind`` of a controller in a file
    ranges: Any
    initial_memory: Callable[[Any], Any]
    step: Callable[[float, Any, Any, dict[str, Any]], tuple[Any, Any]]


class Whole(NamedTuple):
    """A command that is not told in parts."""

    whole: Any

    def command(self) -> Any:
        """The same."""
        return self.whole


def own(law: Law, sample_time: float, limit: float | None = None) -> AxisLaw:
    """The user's ``law`` as that of an axis."""
    return AxisLaw(_parts, _initial_memory, sample_time, limit, law)


def _initial_memory(law: AxisLaw, zero: Scalar) -> Any:
    return law.structure.initial_memory(zero)


def _parts(xp: Xp, law: AxisLaw, gains: Any, memory: Any, signals: Signals) -> tuple[Whole, Any]:
    command, memory = law.structure.step(law.sample_time, gains, memory, signals)
    return Whole(command), memory


def range_fault(pair: Any) -> str | None:
    """What is wrong with a range, in a line; None if nothing is."""
    numbers = isinstance(pair, tuple) and all(isinstance(end, int | float) for end in pair)
    if not numbers or len(pair) != 2 or not all(map(isfinite, pair)):
        return f"{pair!r} is no tuple of two finite numbers"
    return None if pair[0] < pair[1] else f"{pair!r} has to be (low, high)"


def law_fault(law: Law) -> str | None:
    """What keeps a law from being searched, in a line; None if nothing does."""
    if not getattr(law.ranges, "_fields", ()):
        return "ranges has to be a NamedTuple of (low, high)"
    for name, pair in law.ranges._asdict().items():
        if fault := range_fault(pair):
            return f"ranges.{name}: {fault}"
    return None
