"""Objectives: each is a number of a closed loop, the larger the better.

The number is accumulated sample by sample inside the loop, so that the memory does not grow with
the number of samples.
"""

from collections.abc import Callable
from typing import Any, NamedTuple, Self, TypeAlias

from hfc_design.core.numbers import Scalar, Truth
from hfc_design.core.records import NotNegative, Ordered
from hfc_design.motion.samples import PathFrame

#: What an objective has summed up to some sample: scalars in a form that only it knows.
Sums: TypeAlias = Any
#: Least cost: an axis that friction holds may have no error at all, and an infinite fitness would
#: count as a loop that diverges.
FINEST = 1e-9


class Moment(NamedTuple):
    """Inputs of an objective from one axis at one sample; scalars in the units of the plant."""

    error: Scalar
    error_rate: Scalar
    deviation: Scalar  # position minus the position where the axis should be
    command: Scalar
    reference_rate: Scalar
    settled: Scalar  # 1 once the loop should have settled, before that 0
    command_change: Scalar = 0.0  # from the previous sample; before the first, the command is 0
    limited: Truth = False  # whether the command is at a limit
    sliding: Scalar = 0.0  # 1 where, once settled, it should move at half its top speed or more
    beyond: Scalar = 0.0  # distance of the axis beyond the end of the motion, else 0
    late: Scalar = 0.0  # 1 and 2 in the two halves of the motion's last quarter, before that 0
    time: Scalar = 0.0  # [s]
    sample_time: Scalar = 0.0  # [s]
    velocity: Scalar = 0.0  # mean of about the last 10 ms (a lag of the first order)
    apart: Scalar = 0.0  # distance to the copy with a disturbed start, divided by the disturbance
    apart_rate: Scalar = 0.0  # rate of change of ``apart`` [1/s]


class Remaining(NamedTuple):
    """The rest of a motion that is not simulated yet, in control samples."""

    samples: Scalar
    settled: Scalar  # number of these samples that count as settled


NONE_REMAINING = Remaining(0.0, 0.0)


class ObjectiveSettings(Ordered):
    """The ``[fitness]`` of a scenario; an objective with weights adds them."""

    keys_last = ("settled_after_s",)
    kind: str  # which objective
    settled_after_s: NotNegative = 1.0  # time from which a motion counts as settled [s]

    def on(self, units: Any) -> Self:
        """Return the settings in a machine's ``metric.Units``; ValueError: a unit does not fit."""
        return self


class Objective(NamedTuple):
    """A number that says how good a motion is (more is better; it may be negative), as functions.

    ``initial(zero)`` gives empty sums, ``update(sums, moments, path)`` adds one sample of every
    axis, ``score(sums)`` is the number. A loop whose number is not finite has failed. All arguments
    consist of scalars; ``path`` is None for a machine that follows no path. The functions are pure.

    A function with parameters is a ``jax.tree_util.Partial`` over the parameters: then all their
    values share one compiled program, while a closure is compiled for each value.
    """

    initial: Callable[[Scalar], Sums]
    update: Callable[[Sums, tuple[Moment, ...], PathFrame | None], Sums]
    score: Callable[[Sums], Scalar]
    name: str = ""  # the ``kind`` in a scenario
    title: str = ""  # name for readers of tables; "": made from ``name``
    unit: str = ""
    meaning: str = ""  # what it is, in words
    settings: type[ObjectiveSettings] = ObjectiveSettings
    make: Callable[[Any], "Objective"] | None = None  # settings -> objective; None: always this one
    #: (number of axes, whether on a path) -> line on why it cannot judge such a machine, or None.
    fault: Callable[[int, bool], str | None] = lambda axes, path: None
    positive: bool = False  # never below zero
    #: (sums so far, rest of the motion) -> largest possible number at the end; None: unknown.
    best: Callable[[Sums, Remaining], Scalar] | None = None

    def __repr__(self) -> str:
        return f"Objective({self.name!r})"

    @property
    def wordless(self) -> "Objective":
        """The objective without its texts, as a loop needs it."""
        return Objective(self.initial, self.update, self.score, best=self.best)

    def label(self, tail: str = "") -> str:
        """Return the title (or a text with the name), followed by ``tail`` and the unit."""
        unit = f" [{self.unit}]" if self.unit else ""
        return (self.title or f"fitness, {self.name}") + tail + unit
