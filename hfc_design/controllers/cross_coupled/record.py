"""Records of the cross-coupled controller in design files and scenarios. Never imports JAX."""

from operator import not_
from typing import Any, Literal, NamedTuple, Self

from pydantic import Field

from hfc_design.controllers.cross_coupled.law import CrossCoupled, CrossGains
from hfc_design.controllers.gains import FEEDS, GainsSettings
from hfc_design.controllers.kind import Limits, Target, input_ranges, later
from hfc_design.controllers.per_axis import OuterDesign, OwnSettings
from hfc_design.core.numbers import Memory
from hfc_design.core.records import Finite, Label, Record, UserError


class ContourRecord(Record):
    """Gains on the contour error; see ``law.CrossGains``."""

    k_p: Finite  # gain on the contour error [command/error]
    k_i: Finite = 0.0  # gain on the integral of the contour error [command/(error s)]
    k_d: Finite = 0.0  # gain on the rate of the contour error [command s/error]


class CrossCoupledDesign(OuterDesign):
    """Design of kind ``cross-coupled``."""

    kind: Literal["cross-coupled"] = "cross-coupled"
    summary = "axis controllers of any kind plus a PID on the contour error (Koren 1980)"
    settings = later(".record", "CrossCoupledSettings")
    genome = later(".", "CrossCoupledGenome")
    sections = later(".section", "sections")
    path = True
    contour: ContourRecord  # gains of the controller of the contour error
    #: gain of each axis on the velocity of its reference [command s/error]
    feed_forward: dict[Label, Finite] = Field({}, exclude_if=not_)

    def reads(self) -> list[str]:
        """Return the signals that this and the inner controllers read in a sample."""
        signals = ["error", *(["reference_rate"] if self.feed_forward else [])]
        return list(dict.fromkeys([*signals, *self.inner_reads()]))

    def learnt(self, axes: tuple[str, ...], memory: Memory) -> Self | None:
        """Return the design with what the inner controllers learned; None if they cannot learn."""
        return super().learnt(axes, memory.inner)

    def input_range(self, limit: float | None) -> dict[str, float]:
        """Return the velocity whose feed-forward alone commands ``limit`` (None: 1)."""
        largest = max(map(abs, self.feed_forward.values()), default=0.0)
        return input_ranges({"reference_rate": largest}, limit)

    def law_gains(self) -> CrossGains:
        """Return the gains of one individual."""
        velocity = tuple(self.feed_forward.values()) or None
        return CrossGains(self.inner.law_gains(), **dict(self.contour), velocity=velocity)

    def controller(self, limits: Limits) -> CrossCoupled:
        """Return the controller on axes with these limits.

        Raises:
            UserError: the machine does not have two axes, or ``feed_forward`` names other ones.
        """
        axes = tuple(limits)
        if len(axes) != 2:
            message = f"needs the two axes of a path in X-Y (got {len(axes)})"
            raise UserError(f"controller.kind = {self.kind!r}: {message}")
        if self.feed_forward and tuple(self.feed_forward) != axes:
            needed = f"{', '.join(axes)} (got {', '.join(self.feed_forward)})"
            raise UserError(f"controller.feed_forward: must name the axes {needed}")
        inner = self.inner.controller_of(limits)
        return CrossCoupled(self.kind, inner, self.sample_time_s, tuple(limits.values()))


class CrossRanges(NamedTuple):
    """Range (low, high) of each searched gain."""

    k_p: Any  # gain on the contour error [command/error]
    k_i: Any  # gain on the integral of the contour error [command/(error s)]
    k_d: Any  # gain on the rate of the contour error [command s/error]
    velocity: Any  # gain on the velocity of the reference of each axis [command s/error]


class CrossCoupledSettings(GainsSettings):
    """Search ranges of the contour and feed-forward gains, and settings of the inner search."""

    own_ranges = CrossRanges((0.1, 20.0), (0.0, 50.0), (0.0, 1.0), (0.0, 0.1))  # on a feed drive
    own_plants = FEEDS
    kind: Literal["cross-coupled"]
    inner: OwnSettings  # settings of the controllers of the axes

    def fault(self, target: Target) -> str | None:
        """Return why the search is impossible (path, ranges or inner controllers), or None."""
        if not target.follows_path:
            return f"controller.kind = {self.kind!r}: needs a machine that follows a path in X-Y"
        if lacking := super().fault(target):
            return lacking
        inner_fault = self.inner.fault(target)
        return inner_fault and inner_fault.replace("controller.", "controller.inner.", 1)
