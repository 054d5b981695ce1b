"""Controllers: each sees the whole machine and gives every command. Never imports JAX.

Most controllers are the law of one axis, applied to the machine by ``PerAxis``.
"""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, Protocol, TypeAlias

from hfc_design.core.numbers import Gains, Memory, Parameters, Scalar, Xp, clipped

#: Signals of one axis in a sample: ``error``, ``error_rate``, its reference (``FOLLOWED``) and the
#: readings of its drive.
Signals: TypeAlias = Mapping[str, Scalar]
#: Signals of the reference, and their meanings.
FOLLOWED = {
    "reference": "where the axis is to be",
    "reference_rate": "velocity that is commanded",
    "reference_acceleration": "acceleration that is commanded",
}

#: Fields of memories in which laws keep what they learn, slowly beside a loop.
SLOW = frozenset(
    ("root", "rules", "weights", "moved", "moves", "singletons", "change", "action")
) | {f"{side}_{edges}" for side in ("error", "change") for edges in ("rights", "lefts")}


def units_of(units: Mapping[str, str]) -> dict[str, str]:
    """Unit of every signal of one axis, from the units of its drive."""
    position, rate = units["error"], units["error_rate"]
    faster = f"{rate}2" if rate.endswith("/s") else f"{rate}/s"
    return dict(zip(FOLLOWED, (position, rate, faster), strict=True)) | dict(units)


class PathView(NamedTuple):
    """The path of a machine at its reference position, as the control knows it.

    Its distance counts in the unit of the linear axes, or, if only rotary ones move, in theirs.
    """

    tangent: tuple[
        Scalar, ...
    ]  # change of every axis along it; a unit vector of those it counts in
    curvature: Scalar  # of a path in X-Y, positive to the left [1/unit]; of another 0
    contour_error: Scalar  # of the measured position; in X-Y positive to the left, else a distance
    orientation_error: Scalar = 0.0  # of the rotary axes, a distance
    speed: Scalar = 0.0  # commanded along the path [unit/s]
    feed: Scalar = 0.0  # programmed there [unit/s]
    #: Change of the tangent along the path [1/unit], where there may be other axes than X and Y;
    #: None for a rotary axis.
    bend: tuple[Scalar | None, ...] = ()


class View(NamedTuple):
    """Inputs of a controller at a sample, from the whole machine."""

    axes: tuple[Signals, ...]
    path: PathView | None = None  # None: the machine follows no path
    #: The parameters of each axis, as the control believes them to be.
    nominal: tuple[Parameters, ...] | None = None


#: The command of every axis, and what to remember.
Stepped: TypeAlias = tuple[tuple[Scalar, ...], Memory]


class Controller(Protocol):
    """Pure functions of scalars, called once a sample. Hashable: a key of compiled code.

    ``gains`` are the numbers that a search changes, ``memory`` the values kept from one sample to
    the next.
    """

    @property
    def kind(self) -> str:
        """Name of the kind."""

    def initial_memory(self, zero: Scalar) -> Memory:
        """Memory before the first sample."""

    def step(self, xp: Xp, gains: Gains, memory: Memory, view: View) -> Stepped:
        """The command of every axis, and the new memory."""


class AxisLaw(NamedTuple):
    """The law of one axis, in scalars: the same text for the simulator and the runtime.

    ``sample(xp, law, gains, memory, signals)`` returns the command, the new memory, and the parts
    of the command for ``Kind.explain``; these are None if a kind does not explain itself.
    """

    sample: Callable[..., tuple[Scalar, Memory, Any]]
    start: Callable[["AxisLaw", Scalar], Memory]  # (law, zero) -> memory before the first sample
    sample_time: float  # [s]
    limit: float | None = None  # largest command of either sign
    structure: Any = None  # what is code and no number: forms, names of inputs, terms
    #: Its command is not finite wherever what it remembers would break a later sample.
    tells: bool = False
    #: As ``sample``, -> the memory that a first sample begins with; None: as ``start`` gives it.
    prime: Callable[..., Memory] | None = None
    #: (xp, law, gains, memory) -> the memory of a design before its first sample, if it depends on
    #: the gains.
    begin: Callable[..., Memory] | None = None

    def initial_memory(self, zero: Scalar) -> Memory:
        """Memory before the first sample."""
        return self.start(self, zero)

    def begun(self, xp: Xp, zero: Scalar, gains: Gains) -> Memory:
        """Memory of a design before the first sample."""
        memory = self.initial_memory(zero)
        return self.begin(xp, self, gains, memory) if self.begin else memory

    def primed(self, xp: Xp, gains: Gains, memory: Memory, signals: Signals) -> Memory:
        """The ``memory`` before the first sample, the axis standing with these ``signals``."""
        return self.prime(xp, self, gains, memory, signals) if self.prime else memory

    def step(self, xp: Xp, gains: Gains, memory: Memory, signals: Signals) -> tuple[Scalar, Memory]:
        """The command within its limit, and the new memory."""
        command, memory, _ = self.sample(xp, self, gains, memory, signals)
        return limited(xp, self.limit, command), memory


def stood(xp: Xp, law: AxisLaw, gains: Gains, memory: Memory, signals: Signals) -> Memory:
    """A ``prime`` that sets the error of the previous sample to that of this one."""
    return memory._replace(error=signals["error"])


def primed(controller: Controller, xp: Xp, gains: Gains, memory: Memory, view: View) -> Memory:
    """Memory of a ``controller`` before its first sample as if everything had stood as in ``view``.

    So no change of a signal causes a kick. A simulated motion does not need it: there nothing was
    before.
    """
    method = getattr(controller, "primed", None)
    return method(xp, gains, memory, view) if method else memory


def begun(controller: Controller, xp: Xp, zero: Scalar, gains: Gains) -> Memory:
    """Memory of a ``controller`` with these gains before its first sample."""
    method = getattr(controller, "begun", None)
    return method(xp, zero, gains) if method else controller.initial_memory(zero)


class PerAxis(NamedTuple):
    """A controller with a law for each axis; the axes share gains or have their own."""

    kind: str
    laws: tuple[AxisLaw, ...]
    own_gains: bool = False

    def initial_memory(self, zero: Scalar) -> tuple[Memory, ...]:
        """Memory of each axis before the first sample."""
        return tuple(law.initial_memory(zero) for law in self.laws)

    def begun(self, xp: Xp, zero: Scalar, gains: Gains) -> tuple[Memory, ...]:
        """See ``begun``."""
        each = zip(self.laws, self._each(gains), strict=True)
        return tuple(law.begun(xp, zero, axis_gains) for law, axis_gains in each)

    def primed(self, xp: Xp, gains: Gains, memory: Memory, view: View) -> tuple[Memory, ...]:
        """See ``primed``."""
        each = zip(self.laws, self._each(gains), memory, view.axes, strict=True)
        return tuple(
            law.primed(xp, axis_gains, before, axis_signals)
            for law, axis_gains, before, axis_signals in each
        )

    def _each(self, gains: Gains) -> Gains:
        return gains if self.own_gains else (gains,) * len(self.laws)

    def step(self, xp: Xp, gains: Gains, memory: Memory, view: View) -> Stepped:
        """The command of every axis, and the new memory of each."""
        each = zip(self.laws, self._each(gains), memory, view.axes, strict=True)
        stepped = [
            law.step(xp, axis_gains, before, signals) for law, axis_gains, before, signals in each
        ]
        commands, memories = zip(*stepped, strict=True)
        return commands, memories


class RateMemory(NamedTuple):
    """Memory of a controller with rate-limited commands."""

    inner: Memory
    commands: tuple[Scalar, ...]  # of the sample before; 0 before the first one


class RateLimited(NamedTuple):
    """A controller of a machine that limits the change of its commands in a sample.

    The controller inside does not know of the limit: an integral is not held while a command is on
    its way.
    """

    inner: Controller
    limits: tuple[float | None, ...]  # largest command of each axis
    changes: tuple[float | None, ...]  # largest change of it in a sample; None: any

    @property
    def kind(self) -> str:
        """Name of the kind inside."""
        return self.inner.kind

    def initial_memory(self, zero: Scalar) -> RateMemory:
        """Memory before the first sample: nothing was commanded."""
        return RateMemory(self.inner.initial_memory(zero), (zero,) * len(self.changes))

    def begun(self, xp: Xp, zero: Scalar, gains: Gains) -> RateMemory:
        """See ``begun``."""
        return self.initial_memory(zero)._replace(inner=begun(self.inner, xp, zero, gains))

    def primed(self, xp: Xp, gains: Gains, memory: RateMemory, view: View) -> RateMemory:
        """See ``primed``."""
        return memory._replace(inner=primed(self.inner, xp, gains, memory.inner, view))

    def step(self, xp: Xp, gains: Gains, memory: RateMemory, view: View) -> Stepped:
        """The rate-limited commands of the controller inside, and the new memory."""
        requested, inner = self.inner.step(xp, gains, memory.inner, view)
        each = zip(self.limits, self.changes, memory.commands, requested, strict=True)
        commands = tuple(
            ramped(xp, change, before, limited(xp, limit, command))
            for limit, change, before, command in each
        )
        return commands, RateMemory(inner, commands)


def rate_limited(
    controller: Controller, limits: Mapping[str, float | None], changes: Mapping[str, float | None]
) -> Controller:
    """Commands change by at most ``changes`` a sample; the same controller if none is set."""
    if not any(changes.values()):
        return controller
    return RateLimited(controller, tuple(limits.values()), tuple(changes.values()))


def within_rate(memory: Memory) -> Memory:
    """Memory of the controller inside ``RateLimited`` ones, or of one without rate limit."""
    while isinstance(memory, RateMemory):
        memory = memory.inner
    return memory


def ramped(xp: Xp, change: float | None, before: Scalar, command: Scalar) -> Scalar:
    """``command``, at most a change from the one ``before``; nan for an infinite command."""
    if change is None:
        return command
    return clipped(xp, command, before - change, before + change) + 0.0 * command


def limited(xp: Xp, limit: float | None, command: Scalar) -> Scalar:
    """``command``, limited to the same magnitude in both directions."""
    return command if limit is None else clipped(xp, command, -limit, limit)


def outside(xp: Xp, dead_zone: Scalar | None, error: Scalar) -> Scalar:
    """``error``, or 0 within the dead zone; None: there is no dead zone."""
    return error if dead_zone is None else xp.where(abs(error) <= dead_zone, 0.0, error)


def held(xp: Xp, limit: float | None, command: Scalar, before: Scalar, after: Scalar) -> Scalar:
    """Return the new value ``after`` of an integral, or its old value ``before`` against windup.

    The integral keeps its old value while the ``command`` that contains it is beyond the limit and
    the step would increase the excess (clamping anti-windup).
    """
    if limit is None:
        return after
    further = (after - before) * command > 0.0
    if xp.sparse:  # a processor guesses that it is not
        return xp.when(abs(command) > limit, lambda: xp.where(further, before, after), after)
    return xp.where((abs(command) > limit) & further, before, after)
