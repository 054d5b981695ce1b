"""Cross-coupled control: axis controllers and a common controller of the contour error.

The law is the symmetric form of Koren (1980) with the variable gains of Koren & Lo (1991): on arcs
the normal of the path is turned towards the point of the path that is nearest to the machine. It is
written for one machine in scalars; ``xp`` as in ``core.numbers``. Never imports JAX.
"""

from collections.abc import Sequence
from typing import NamedTuple

from hfc_design.controllers.controller import (
    Controller,
    PathView,
    Stepped,
    View,
    begun,
    limited,
    primed,
)
from hfc_design.core.numbers import Gains, Memory, Scalar, Truth, Xp
from hfc_design.core.records import UserError

NO_PATH = "a cross-coupled controller needs the path of an X-Y machine"


class CrossGains(NamedTuple):
    """Gains of one individual; for a population, arrays whose last dimension counts individuals."""

    inner: Gains  # gains of the axis controllers
    k_p: Scalar  # gain on the contour error [command/error]
    k_i: Scalar  # gain on the integral of the contour error [command/(error s)]
    k_d: Scalar  # gain on the rate of the contour error [command s/error]
    #: gain of each axis on the velocity of its reference [command s/error]; None: 0
    velocity: Sequence[Scalar] | None = None


class CrossMemory(NamedTuple):
    """Memory of the controller; before the first sample everything except ``inner`` is zero."""

    inner: Memory
    error: Scalar  # contour error of the previous sample
    integral: Scalar  # integral part of the command against the contour error [command]


class CrossCoupled(NamedTuple):
    """Cross-coupled controller of an X-Y machine."""

    kind: str
    inner: Controller
    sample_time: float  # [s]
    limits: tuple[float | None, ...]  # largest command of each axis

    def initial_memory(self, zero: Scalar) -> CrossMemory:
        """Return the memory before the first sample: the machine at rest on its path."""
        return CrossMemory(self.inner.initial_memory(zero), zero, zero)

    def begun(self, xp: Xp, zero: Scalar, gains: CrossGains) -> CrossMemory:
        """Return the initial memory, with the inner controllers begun from their gains."""
        return self.initial_memory(zero)._replace(inner=begun(self.inner, xp, zero, gains.inner))

    def primed(self, xp: Xp, gains: CrossGains, memory: CrossMemory, view: View) -> CrossMemory:
        """Return the memory with the present contour error as the previous one."""
        inner = primed(self.inner, xp, gains.inner, memory.inner, view)
        error = memory.error if view.path is None else view.path.contour_error
        return memory._replace(inner=inner, error=error)

    def step(self, xp: Xp, gains: CrossGains, memory: CrossMemory, view: View) -> Stepped:
        """Return axis commands and feed-forward, corrected along the normal; UserError: no path."""
        if view.path is None:
            raise UserError(NO_PATH)
        inner, inner_memory = self.inner.step(xp, gains.inner, memory.inner, view)
        shares, error = _normal(view.path, view), view.path.contour_error
        pd_part = gains.k_p * error + gains.k_d * ((error - memory.error) / self.sample_time)
        step = gains.k_i * self.sample_time * error
        before = memory.integral
        ahead = _fed_forward(gains, view)

        def commands(integral: Scalar) -> list[Scalar]:
            each = zip(inner, ahead, shares, strict=True)
            return [u + forward - share * (pd_part + integral) for u, forward, share in each]

        further = [-share * step for share in shares]  # change of each command by the step
        wound = self._wound(commands(before + step), further)
        integral = before + step if wound is None else xp.where(wound, before, before + step)
        pairs = zip(self.limits, commands(integral), strict=True)
        saturated = tuple(limited(xp, limit, command) for limit, command in pairs)
        return saturated, CrossMemory(inner_memory, error, integral)

    def _wound(self, commands: list[Scalar], further: list[Scalar]) -> Truth | None:
        """True if a command is beyond its limit and the integral's step would push it further."""
        winding_up = None
        for limit, command, step in zip(self.limits, commands, further, strict=True):
            if limit is not None:
                beyond = (abs(command) > limit) & (step * command > 0.0)
                winding_up = beyond if winding_up is None else winding_up | beyond
        return winding_up


def _normal(path: PathView, view: View) -> tuple[Scalar, Scalar]:
    """Left normal of the path at the machine's position (Koren & Lo 1991, C_x and C_y)."""
    half = 0.5 * path.curvature
    x, y = (signals["error"] for signals in view.axes)
    return half * x - path.tangent[1], half * y + path.tangent[0]


def _fed_forward(gains: CrossGains, view: View) -> tuple[Scalar, ...]:
    """Return the command of each axis in proportion to its reference velocity."""
    if gains.velocity is None:
        return tuple(0.0 * signals["error"] for signals in view.axes)
    pairs = zip(gains.velocity, view.axes, strict=True)
    return tuple(gain * signals["reference_rate"] for gain, signals in pairs)
