"""Objectives: each is a number of a closed loop, the larger the better.

It is accumulated sample by sample inside the loop, so that the memory does not grow with the number
of samples.
"""

from collections.abc import Callable
from typing import Any, NamedTuple, Self, TypeAlias

from hfc_design.core.numbers import Scalar, Truth
from hfc_design.core.records import NotNegative, Ordered
from hfc_design.motion.samples import PathFrame

#: What only its objective knows: what it has added up by some sample, scalars.
Sums: TypeAlias = Any
#: Least cost: an axis that friction holds may have no error at all, and an infinite fitness would
#: count as a loop that diverges.
FINEST = 1e-9


class Moment(NamedTuple):
    """Inputs of an objective from one axis at one sample; scalars in the units of the plant."""

    error: Scalar
    error_rate: Scalar
    deviation: Scalar  # from where the axis should be, its sign the other way round
    command: Scalar
    reference_rate: Scalar
    settled: Scalar  # 1 once the loop should have settled, before that 0
    command_change: Scalar = 0.0  # since the previous sample, before the first it was 0
    limited: Truth = False  # whether the command is at a limit
    sliding: Scalar = 0.0  # 1 where, once settled, it is to move at half its top speed at least
    beyond: Scalar = 0.0  # how far beyond where the motion ends
    late: Scalar = 0.0  # 1 and 2 in the halves of the motion's last quarter, before that 0
    time: Scalar = 0.0  # [s]
    sample_time: Scalar = 0.0  # [s]
    velocity: Scalar = 0.0  # mean of the last 10 ms (a lag of the first order)
    apart: Scalar = 0.0  # of a copy that began a little off, as a share of that
    apart_rate: Scalar = 0.0  # [1/s]


class Remaining(NamedTuple):
    """The rest of a motion that is not simulated yet."""

    samples: Scalar
    settled: Scalar  # those of them that count as settled


NONE_REMAINING = Remaining(0.0, 0.0)


class ObjectiveSettings(Ordered):
    """The ``[fitness]`` of a scenario; an objective with weights adds them."""

    keys_last = ("settled_after_s",)
    kind: str  # which objective
    settled_after_s: NotNegative = 1.0  # time from which a motion counts as settled [s]

    def on(self, units: Any) -> Self:
        """The settings in numbers of a machine's ``metric.Units``; ValueError: they cannot be."""
        return self


class Objective(NamedTuple):
    """A number as pure functions of scalars, the larger the better; it may be negative.

    Functions that hold numbers are ``jax.tree_util.Partial`` of these: then all values of the
    numbers share a compiled program, while a closure over the numbers is compiled for each value.

    ``initial(zero)`` gives empty sums, ``update(sums, moments, path)`` adds one sample of every
    axis, ``score(sums)`` is the number. A loop whose number is not finite has failed. ``path``
    consists of scalars, and is None for a machine of one axis.
    """

    initial: Callable[[Scalar], Sums]
    update: Callable[[Sums, tuple[Moment, ...], PathFrame | None], Sums]
    score: Callable[[Sums], Scalar]
    name: str = ""  # the ``kind`` in a scenario
    title: str = ""  # what people read; "" for the name
    unit: str = ""
    meaning: str = ""  # what it is, in words
    settings: type[ObjectiveSettings] = ObjectiveSettings
    make: Callable[[Any], "Objective"] | None = None  # of settings; None: they change nothing
    #: Why it cannot judge a machine of so many axes, on a path or not, in a line.
    fault: Callable[[int, bool], str | None] = lambda axes, path: None
    positive: bool = False  # never below zero
    #: What the number can be at most in the end, of the sums by now; None: anything.
    best: Callable[[Sums, Remaining], Scalar] | None = None

    def __repr__(self) -> str:
        return f"Objective({self.name!r})"

    @property
    def wordless(self) -> "Objective":
        """The objective without texts for people, as a loop computes it."""
        return Objective(self.initial, self.update, self.score, best=self.best)

    def label(self, tail: str = "") -> str:
        """Text for people: the title, followed by ``tail`` and the unit."""
        unit = f" [{self.unit}]" if self.unit else ""
        return (self.title or f"fitness, {self.name}") + tail + unit
