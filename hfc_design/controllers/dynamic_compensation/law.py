"""Dynamic compensation of the tracking error of a whole machine (Lin & Gai 2009, cited as LG09).

The following command is added to that of each axis' controller, with e the errors of all axes and
le their Euclidean length (LG09 eq. 3 to 6)::

    u_c = k_p (v_i / v) (e_i / le) (le - e_max)    where le > e_max, else 0

The paper prints eq. 3 without fractions and brackets; this reading fits all five principles that
precede it. v_i is the commanded speed along the path, v the programmed one. The law is written
for one machine in scalars; ``xp`` as in ``core.numbers``. Never imports JAX.
"""

from collections.abc import Sequence
from typing import NamedTuple

from hfc_design.controllers.controller import Controller, Stepped, View, begun, limited, primed
from hfc_design.core.numbers import Gains, Memory, Scalar, Xp, total


class CompensationGains(NamedTuple):
    """Gains of one individual; for a population, arrays whose last dimension counts individuals."""

    inner: Gains  # gains of the inner controllers
    k_p: Sequence[Scalar]  # gain of each axis [command/error]
    dead_zone: Scalar  # e_max; the length of all errors adds mm and deg [error]
    speed: Scalar  # v, the programmed speed along the path [error/s]


class DynamicCompensation(NamedTuple):
    """Inner controller of a machine with the compensation added."""

    kind: str
    inner: Controller
    along: tuple[int, ...]  # indices of the axes that make up the speed along the path
    limits: tuple[float | None, ...]  # largest command of each axis

    def initial_memory(self, zero: Scalar) -> Memory:
        """Return the inner controllers' memory; the compensation has none."""
        return self.inner.initial_memory(zero)

    def begun(self, xp: Xp, zero: Scalar, gains: CompensationGains) -> Memory:
        """Return the inner controllers' memory, begun from their gains."""
        return begun(self.inner, xp, zero, gains.inner)

    def primed(self, xp: Xp, gains: CompensationGains, memory: Memory, view: View) -> Memory:
        """Return the inner controllers' memory, primed with the first view."""
        return primed(self.inner, xp, gains.inner, memory, view)

    def step(self, xp: Xp, gains: CompensationGains, memory: Memory, view: View) -> Stepped:
        """Return the inner controllers' commands with the compensation added."""
        inner, memory = self.inner.step(xp, gains.inner, memory, view)
        share = speed_share(xp, gains.speed, [view.axes[k]["reference_rate"] for k in self.along])
        errors = [signals["error"] for signals in view.axes]
        factor = xp.once(share * beyond(xp, gains.dead_zone, errors))
        each = zip(self.limits, inner, gains.k_p, errors, strict=True)
        return tuple(limited(xp, limit, u + k * (factor * e)) for limit, u, k, e in each), memory


def beyond(xp: Xp, dead_zone: Scalar, errors: Sequence[Scalar]) -> Scalar:
    """Return ``(le - e_max) / le``, where le is the length of ``errors``; 0 in the dead zone."""
    square = xp.maximum(total(error * error for error in errors), dead_zone * dead_zone)
    return 1.0 - dead_zone / xp.sqrt(square)


def speed_share(xp: Xp, speed: Scalar, rates: Sequence[Scalar]) -> Scalar:
    """Return ``v_i / v``, at most 1; v_i is the length of ``rates``, v the programmed ``speed``."""
    return xp.sqrt(xp.minimum(total(rate * rate for rate in rates) / (speed * speed), 1.0))
