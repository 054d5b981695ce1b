"""Records of dynamic compensation in design files and scenarios. Never imports JAX."""

from operator import not_
from typing import Any, Literal, NamedTuple

from pydantic import Field

from hfc_design.controllers.dynamic_compensation.law import CompensationGains, DynamicCompensation
from hfc_design.controllers.gains import GainsSettings
from hfc_design.controllers.kind import Limits, Target, later
from hfc_design.controllers.per_axis import OuterDesign, OwnSettings
from hfc_design.core.records import Finite, Label, Positive, UserError

#: Gain of each axis by the axis' name [command / unit of its error].
Gain = dict[Label, Finite]


class CompensationDesign(OuterDesign):
    """Design of kind ``dynamic-compensation``; see ``law``."""

    kind: Literal["dynamic-compensation"] = "dynamic-compensation"
    summary = "any controllers plus a compensation by the length of all errors (Lin & Gai)"
    settings = later(".record", "CompensationSettings")
    genome = later(".", "CompensationGenome")
    sections = later(".section", "sections")
    k_p: Gain  # gain on the excess of the errors over the dead zone, LG09 eq. 3 [command/error]
    dead_zone: Positive  # e_max: length of all errors up to which nothing is added [error]
    programmed_speed: Positive  # v: speed along the path that the gain refers to [error/s]
    #: axes that make up the speed along the path; left out: all
    path_axes: tuple[Label, ...] = Field((), exclude_if=not_)

    def reads(self) -> list[str]:
        """Return the signals that this and the inner controllers read in a sample."""
        return list(dict.fromkeys(["error", "reference_rate", *self.inner_reads()]))

    def input_range(self, limit: float | None) -> dict[str, float]:
        """Return twice the dead zone for the error, the programmed speed for ``reference_rate``."""
        return {"error": 2.0 * self.dead_zone, "reference_rate": self.programmed_speed}

    def law_gains(self) -> CompensationGains:
        """Return the gains of one individual."""
        inner = self.inner.law_gains()
        k_p = tuple(self.k_p.values())
        return CompensationGains(inner, k_p, self.dead_zone, self.programmed_speed)

    def controller(self, limits: Limits) -> DynamicCompensation:
        """Return the controller on axes with these limits.

        Raises:
            UserError: ``k_p`` or ``path_axes`` do not fit the axes of the machine.
        """
        axes = tuple(limits)
        if fault := axes_fault(axes, self.k_p, self.path_axes):
            raise UserError(f"controller.{fault}")
        along = tuple(axes.index(axis) for axis in self.path_axes or axes)
        inner = self.inner.controller_of(limits)
        return DynamicCompensation(self.kind, inner, along, tuple(limits.values()))


def axes_fault(axes: tuple[str, ...], k_p: Gain, along: tuple[str, ...]) -> str | None:
    """Return why ``k_p`` or ``along`` does not fit a machine with ``axes``, in a line, or None."""
    has = f"the machine has {', '.join(axes)}"
    if tuple(k_p) != axes:
        return f"k_p: must name the axes {', '.join(axes)}, in this order (got {', '.join(k_p)})"
    for axis in along:
        if axis not in axes:
            return f"path_axes: unknown axis {axis!r}; {has}"
    if len(set(along)) < len(along):
        return f"path_axes: must not name an axis twice; {has}"
    return None


class CompensationRanges(NamedTuple):
    """Range (low, high) of each searched factor on a setting."""

    k_p: Any  # factor on the k_p of every axis [1]
    dead_zone: Any  # factor on the dead zone [1]


class CompensationSettings(GainsSettings):
    """Settings of a search: initial gains, ranges of factors on them, and inner controllers."""

    own_ranges = CompensationRanges((0.05, 5.0), (0.05, 5.0))
    kind: Literal["dynamic-compensation"]
    inner: OwnSettings  # settings of the wrapped controllers
    k_p: Gain  # gain on the excess of the errors over the dead zone, LG09 eq. 3 [command/error]
    dead_zone: Positive  # e_max: length of all errors up to which nothing is added [error]
    programmed_speed: Positive  # v: speed along the path that the gain refers to [error/s]
    path_axes: tuple[Label, ...] = ()  # axes that make up the speed along the path; none: all

    def fault(self, target: Target) -> str | None:
        """Return why the search is impossible (axes or inner controllers), or None."""
        if fault := axes_fault(target.machine.axes, self.k_p, self.path_axes):
            return f"controller.{fault}"
        inner_fault = self.inner.fault(target)
        return inner_fault and inner_fault.replace("controller.", "controller.inner.", 1)
