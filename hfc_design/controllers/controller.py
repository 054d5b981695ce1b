"""Definition of a controller, which reads all axes of a machine and commands each of them.

Most controllers apply the law of one axis to every axis (``PerAxis``). Never imports JAX.
"""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, Protocol, TypeAlias

from hfc_design.core.numbers import Gains, Memory, Parameters, Scalar, Xp, clipped

#: Signals of one axis in a sample, by name: ``error``, ``error_rate``, those of its reference
#: (``FOLLOWED``) and the readings of its drive.
Signals: TypeAlias = Mapping[str, Scalar]
#: Signals of the reference, and their meanings.
FOLLOWED = {
    "reference": "where the axis is to be",
    "reference_rate": "velocity that is commanded",
    "reference_acceleration": "acceleration that is commanded",
}

#: Fields of memories that hold what laws learn; they change slowly compared with the loop.
SLOW = frozenset(
    ("root", "rules", "weights", "moved", "moves", "singletons", "change", "action")
) | {f"{side}_{edges}" for side in ("error", "change") for edges in ("rights", "lefts")}


def units_of(units: Mapping[str, str]) -> dict[str, str]:
    """Return the unit of every signal of one axis by name, from the ``units`` of its drive."""
    position, rate = units["error"], units["error_rate"]
    faster = f"{rate}2" if rate.endswith("/s") else f"{rate}/s"
    return dict(zip(FOLLOWED, (position, rate, faster), strict=True)) | dict(units)


class PathView(NamedTuple):
    """Path of a machine at its reference position, as the controller knows it.

    The length of the path is in the unit of the linear axes; if only rotary axes move, in theirs.
    """

    #: Derivative of each axis' position by the length; a unit vector of the axes that have the
    #: unit of the length.
    tangent: tuple[Scalar, ...]
    curvature: Scalar  # of a path in X-Y, positive if it bends left [1/unit]; 0 of other paths
    contour_error: Scalar  # of the position; in X-Y positive to the left, for other axes a distance
    orientation_error: Scalar = 0.0  # distance of the rotary axes from their place on the path
    speed: Scalar = 0.0  # commanded speed along the path [unit/s]
    feed: Scalar = 0.0  # speed that the program asks for [unit/s]
    #: Derivative of the tangent by the length [1/unit], None for a rotary axis; empty if the path
    #: is known to have only X and Y.
    bend: tuple[Scalar | None, ...] = ()


class View(NamedTuple):
    """Inputs of a controller in one sample, from all axes of a machine."""

    axes: tuple[Signals, ...]
    path: PathView | None = None  # None: the machine follows no path
    #: Parameters of each axis that the controller assumes; None: it has none.
    nominal: tuple[Parameters, ...] | None = None


#: The command of every axis, and the memory for the next sample.
Stepped: TypeAlias = tuple[tuple[Scalar, ...], Memory]


class Controller(Protocol):
    """Controller as pure functions of scalars; hashable, since compiled programs are found by it.

    ``gains`` are the numbers that a search changes, ``memory`` the values kept from one sample to
    the next.
    """

    @property
    def kind(self) -> str:
        """Name of the kind."""

    def initial_memory(self, zero: Scalar) -> Memory:
        """Return the memory before the first sample."""

    def step(self, xp: Xp, gains: Gains, memory: Memory, view: View) -> Stepped:
        """Return the command of every axis in a sample, and the new memory."""


class AxisLaw(NamedTuple):
    """Law of one axis as functions of scalars, which the simulator and the runtime both call.

    ``sample(xp, law, gains, memory, signals)`` returns the command, the new memory, and the parts
    of the command for ``ControllerRecord.explain``, or None if a kind does not explain itself.
    """

    sample: Callable[..., tuple[Scalar, Memory, Any]]
    start: Callable[["AxisLaw", Scalar], Memory]  # (law, zero) -> memory before the first sample
    sample_time: float  # [s]
    limit: float | None = None  # largest command of either sign
    structure: Any = None  # what the law needs besides gains: a form, names of inputs, terms
    #: True if the command is not finite whenever the new memory would spoil a later command.
    tells: bool = False
    #: (xp, law, gains, memory, signals) -> memory for the first sample; None: that of ``start``.
    prime: Callable[..., Memory] | None = None
    #: (xp, law, gains, memory) -> memory before the first sample, if it depends on the gains;
    #: None: it does not.
    begin: Callable[..., Memory] | None = None

    def initial_memory(self, zero: Scalar) -> Memory:
        """Return the memory before the first sample, for any gains."""
        return self.start(self, zero)

    def begun(self, xp: Xp, zero: Scalar, gains: Gains) -> Memory:
        """Return the memory before the first sample, for these gains."""
        memory = self.initial_memory(zero)
        return self.begin(xp, self, gains, memory) if self.begin else memory

    def primed(self, xp: Xp, gains: Gains, memory: Memory, signals: Signals) -> Memory:
        """Return ``memory`` as if the axis had been at rest with these ``signals`` before."""
        return self.prime(xp, self, gains, memory, signals) if self.prime else memory

    def step(self, xp: Xp, gains: Gains, memory: Memory, signals: Signals) -> tuple[Scalar, Memory]:
        """Return the command within its limit, and the new memory."""
        command, memory, _ = self.sample(xp, self, gains, memory, signals)
        return limited(xp, self.limit, command), memory


def stood(xp: Xp, law: AxisLaw, gains: Gains, memory: Memory, signals: Signals) -> Memory:
    """Return the memory with the present error as the previous one; for ``AxisLaw.prime``."""
    return memory._replace(error=signals["error"])


def primed(controller: Controller, xp: Xp, gains: Gains, memory: Memory, view: View) -> Memory:
    """Return ``memory`` as if the machine had been at rest as in ``view`` before the first sample.

    So the first command has no jump that comes from a change of a signal. Simulated motions do not
    use it: they start with the memory of ``begun``.
    """
    method = getattr(controller, "primed", None)
    return method(xp, gains, memory, view) if method else memory


def begun(controller: Controller, xp: Xp, zero: Scalar, gains: Gains) -> Memory:
    """Return the memory of a ``controller`` with these gains before its first sample."""
    method = getattr(controller, "begun", None)
    return method(xp, zero, gains) if method else controller.initial_memory(zero)


class PerAxis(NamedTuple):
    """Controller with a law for each axis; all axes share one set of gains, or each has its own."""

    kind: str
    laws: tuple[AxisLaw, ...]
    own_gains: bool = False

    def initial_memory(self, zero: Scalar) -> tuple[Memory, ...]:
        """Return the memory of each axis before the first sample."""
        return tuple(law.initial_memory(zero) for law in self.laws)

    def begun(self, xp: Xp, zero: Scalar, gains: Gains) -> tuple[Memory, ...]:
        """See the function ``begun``."""
        each = zip(self.laws, self._each(gains), strict=True)
        return tuple(law.begun(xp, zero, axis_gains) for law, axis_gains in each)

    def primed(self, xp: Xp, gains: Gains, memory: Memory, view: View) -> tuple[Memory, ...]:
        """See the function ``primed``."""
        each = zip(self.laws, self._each(gains), memory, view.axes, strict=True)
        return tuple(
            law.primed(xp, axis_gains, before, axis_signals)
            for law, axis_gains, before, axis_signals in each
        )

    def _each(self, gains: Gains) -> Gains:
        return gains if self.own_gains else (gains,) * len(self.laws)

    def step(self, xp: Xp, gains: Gains, memory: Memory, view: View) -> Stepped:
        """Return the command of every axis, and the new memory of each axis."""
        each = zip(self.laws, self._each(gains), memory, view.axes, strict=True)
        stepped = [
            law.step(xp, axis_gains, before, signals) for law, axis_gains, before, signals in each
        ]
        commands, memories = zip(*stepped, strict=True)
        return commands, memories


class RateMemory(NamedTuple):
    """Memory of a controller with rate-limited commands."""

    inner: Memory
    commands: tuple[Scalar, ...]  # commands of the previous sample; 0 before the first sample


class RateLimited(NamedTuple):
    """Controller of a machine that limits how much the commands of an inner one change per sample.

    The inner controller does not know this limit: its integrals also change while a command is
    still on the way to the value that the inner controller gave.
    """

    inner: Controller
    limits: tuple[float | None, ...]  # largest command of each axis
    changes: tuple[float | None, ...]  # largest change of each command in a sample; None: any

    @property
    def kind(self) -> str:
        """Name of the kind of the inner controller."""
        return self.inner.kind

    def initial_memory(self, zero: Scalar) -> RateMemory:
        """Return the memory before the first sample; the previous commands are 0."""
        return RateMemory(self.inner.initial_memory(zero), (zero,) * len(self.changes))

    def begun(self, xp: Xp, zero: Scalar, gains: Gains) -> RateMemory:
        """See the function ``begun``."""
        return self.initial_memory(zero)._replace(inner=begun(self.inner, xp, zero, gains))

    def primed(self, xp: Xp, gains: Gains, memory: RateMemory, view: View) -> RateMemory:
        """See the function ``primed``."""
        return memory._replace(inner=primed(self.inner, xp, gains, memory.inner, view))

    def step(self, xp: Xp, gains: Gains, memory: RateMemory, view: View) -> Stepped:
        """Return the rate-limited commands of the inner controller, and the new memory."""
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
    """Return ``controller`` with commands that change by at most ``changes`` in a sample."""
    if not any(changes.values()):
        return controller
    return RateLimited(controller, tuple(limits.values()), tuple(changes.values()))


def within_rate(memory: Memory) -> Memory:
    """Return the inner memory of a ``RateLimited`` controller; any other memory as it is."""
    while isinstance(memory, RateMemory):
        memory = memory.inner
    return memory


def ramped(xp: Xp, change: float | None, before: Scalar, command: Scalar) -> Scalar:
    """Return ``command`` within ``change`` of ``before``, inf as nan; None: command as it is."""
    if change is None:
        return command
    return clipped(xp, command, before - change, before + change) + 0.0 * command


def limited(xp: Xp, limit: float | None, command: Scalar) -> Scalar:
    """Return ``command``, limited to -``limit`` to ``limit``; None: not limited."""
    return command if limit is None else clipped(xp, command, -limit, limit)


def outside(xp: Xp, dead_zone: Scalar | None, error: Scalar) -> Scalar:
    """Return ``error``, or 0 if it is at most ``dead_zone`` either way; None: no dead zone."""
    return error if dead_zone is None else xp.where(abs(error) <= dead_zone, 0.0, error)


def held(xp: Xp, limit: float | None, command: Scalar, before: Scalar, after: Scalar) -> Scalar:
    """Return the new value ``after`` of an integral, or its old value ``before`` against windup.

    The integral keeps its old value while the ``command`` that contains it is beyond the limit and
    the step would increase the excess (clamping anti-windup).
    """
    if limit is None:
        return after
    further = (after - before) * command > 0.0
    if xp.sparse:  # branches: a processor predicts that the command is within its limit
        return xp.when(abs(command) > limit, lambda: xp.where(further, before, after), after)
    return xp.where((abs(command) > limit) & further, before, after)
