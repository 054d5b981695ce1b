"""Self-organising fuzzy controller of Huang & Shy (``milling-table``). Never imports JAX.

A table of 11 x 11 commands over error and change of error is corrected by the error itself: there
is no performance table, and no model but a direction. Written for one axis in scalars, over the
whole table: a gather would cost more. ``xp`` as in ``core.numbers``.

Interpretation of the paper where it leaves a choice:

- The command is the output of the table, not its sum over the samples.
- An error, or its change, beyond the outermost set is limited to it: 5 after its gain. The same
  numbers correct the rules, which limits the correction by a large error.
- The rules that fire at a sample are corrected with its own error, for the next time they fire.
- A rule is limited to the command's limit: it would wind up otherwise.
- The paper's M, the gain of the machine, is 1: another M is another ``gamma``.
"""

from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

from hfc_design.controllers.controller import AxisLaw, Signals, stood
from hfc_design.controllers.neighbours import Degrees, changed, evenly, weighted
from hfc_design.core.numbers import Scalar, Xp, clipped

#: Highest set of an input; the sets are -HIGHEST to HIGHEST.
HIGHEST = 5
SETS = 2 * HIGHEST + 1
LABELS = [f"{place:+d}" if place else "0" for place in range(-HIGHEST, HIGHEST + 1)]
#: Commands (11, 11) before ``gu``, rows by the error and columns by its change, from -5 to 5.
Rules: TypeAlias = Sequence[Sequence[Scalar]]


class SocGains(NamedTuple):
    """Searched gains, on errors and commands in the units of the drive."""

    ge: Scalar  # sets per unit of the error [1/error]
    gc: Scalar  # sets per unit of its change in a sample [1/error]
    gu: Scalar  # command for a rule of 1 [command]
    gamma: Scalar  # share of the error that a correction removes [1]
    xi: Scalar  # weight of the change in it, that of the error is 1 - xi [1]


class SocMemory(NamedTuple):
    """Memory of the controller."""

    error: Scalar  # e(k-1)
    rules: Rules


class Parts(NamedTuple):
    """Parts of a command."""

    error: Scalar  # in sets
    change: Scalar  # in sets
    in_error: Sequence[Scalar]  # (11,) degrees
    in_change: Sequence[Scalar]  # (11,)
    rules: Rules  # as they act in this sample
    inferred: Scalar  # what they give


def soc(rules: Rules, sample_time: float, limit: float | None = None) -> AxisLaw:
    """Return the law with the initial ``rules``."""
    return AxisLaw(sample, initial_memory, sample_time, limit, rules, tells=True, prime=stood)


def initial_memory(law: AxisLaw, zero: Scalar) -> SocMemory:
    """Return the memory before the first sample: the axis at rest on its reference."""
    return SocMemory(zero, [[zero + rule for rule in row] for row in law.structure])


def sample(
    xp: Xp, law: AxisLaw, gains: SocGains, memory: SocMemory, signals: Signals
) -> tuple[Scalar, SocMemory, Parts]:
    """Return the command of one sample: ``u = gu sum(w_i U_i)`` over the four rules that fire.

    Each then moves by ``w_i gamma ((1 - xi) e + xi ce)`` (eq. 8 and 9), e and ce in sets.
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
    """Return the degrees (11,) of a value in the sets: linear between two neighbours, sum 1."""
    return evenly(xp, value, HIGHEST)
