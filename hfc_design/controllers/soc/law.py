"""Self-organising fuzzy controller of Huang & Shy (``milling-table``). Never imports JAX.

The error corrects a table of 11 x 11 commands over the error and its change. There is no table of
desired performance, and no model of the machine except the sign of its gain. The law is written
for one axis in scalars; ``xp`` as in ``core.numbers``.

Interpretation of the paper where it leaves a choice:

- The command is the output of the table, not its sum over the samples.
- An error, or its change, beyond the outermost set counts as 5 sets (as -5 if negative). The same
  limited numbers correct the rules, so that a large error does not correct them more.
- The rules that fire in a sample are corrected by the error of that sample, for later samples.
- A rule is limited to the limit of the command, because it would wind up otherwise.
- The paper's M, the gain of the machine, is 1 here: another M would only change ``gamma``.
"""

from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

from hfc_design.controllers.controller import AxisLaw, Signals, stood
from hfc_design.controllers.neighbours import Degrees, changed, evenly, weighted
from hfc_design.core.numbers import Scalar, Xp, clipped

#: Number of the highest fuzzy set of an input; the sets are -HIGHEST to HIGHEST.
HIGHEST = 5
SETS = 2 * HIGHEST + 1
LABELS = [f"{place:+d}" if place else "0" for place in range(-HIGHEST, HIGHEST + 1)]
#: (11, 11) commands divided by ``gu``; rows: error, columns: its change, both from set -5 to 5.
Rules: TypeAlias = Sequence[Sequence[Scalar]]


class SocGains(NamedTuple):
    """Searched gains, on errors and commands in the units of the drive."""

    ge: Scalar  # sets per unit of the error [1/error]
    gc: Scalar  # sets per unit of the error's change in a sample [1/error]
    gu: Scalar  # command for a rule of 1 [command]
    gamma: Scalar  # share of the error that a correction removes [1]
    xi: Scalar  # weight of the error's change in a correction; the error itself has 1 - xi [1]


class SocMemory(NamedTuple):
    """Memory of the controller."""

    error: Scalar  # error of the previous sample
    rules: Rules  # present table


class Parts(NamedTuple):
    """Values from which the command of a sample follows."""

    error: Scalar  # error, counted in sets
    change: Scalar  # change of the error, counted in sets
    in_error: Sequence[Scalar]  # (11,) degrees of the error
    in_change: Sequence[Scalar]  # (11,) degrees of the change
    rules: Rules  # table of this sample, before its correction
    inferred: Scalar  # output of the table, the command divided by ``gu``


def soc(rules: Rules, sample_time: float, limit: float | None = None) -> AxisLaw:
    """Return the law with the initial ``rules``."""
    return AxisLaw(sample, initial_memory, sample_time, limit, rules, tells=True, prime=stood)


def initial_memory(law: AxisLaw, zero: Scalar) -> SocMemory:
    """Return the memory before the first sample: the axis at rest on its reference."""
    return SocMemory(zero, [[zero + rule for rule in row] for row in law.structure])


def sample(
    xp: Xp, law: AxisLaw, gains: SocGains, memory: SocMemory, signals: Signals
) -> tuple[Scalar, SocMemory, Parts]:
    """Return the command ``u = gu sum(w_i U_i)`` over the four rules that fire, memory and parts.

    Then each U_i moves by ``w_i gamma ((1 - xi) e + xi ce)`` (eq. 8 and 9), with e and ce in sets.
    """
    error = signals["error"]
    e = xp.once(clipped(xp, gains.ge * error, -HIGHEST, HIGHEST))
    ce = xp.once(clipped(xp, gains.gc * (error - memory.error), -HIGHEST, HIGHEST))
    in_error, in_change = degrees(xp, e), degrees(xp, ce)
    inferred = xp.sure(weighted(xp, in_error, in_change, memory.rules))
    correction = gains.gamma * ((1.0 - gains.xi) * e + gains.xi * ce)
    top = None if law.limit is None else xp.ratio(law.limit, gains.gu)

    def step(degree: Scalar) -> Scalar:
        return xp.once(degree * correction)

    def moved(size: Scalar, other: Scalar, rule: Scalar) -> Scalar:
        rule = rule + size * other
        return rule if top is None else clipped(xp, rule, -top, top)

    rules = changed(xp, in_error, in_change, memory.rules, step, moved)
    parts = Parts(e, ce, in_error, in_change, memory.rules, inferred)
    return gains.gu * inferred, SocMemory(error, rules), parts


def degrees(xp: Xp, value: Scalar) -> Degrees:
    """Return the degrees (11,) of a value in the sets, triangles whose degrees add up to 1."""
    return evenly(xp, value, HIGHEST)
