"""The self-organising fuzzy controller of Huang & Shy (``milling-table``). Never imports JAX.

A table of 11 x 11 commands over error and change of error, which the error itself corrects: there
is no table of how good a sample was, and no model but a direction. Written for one axis in scalars,
over the whole table: a gather would cost more. ``xp`` as in ``core.numbers``.

How the paper is read where it leaves a choice:

- The command is what the table gives, not its sum over the samples.
- Beyond its outermost set an error, or its change, counts as there: 5 after its gain. The same
  numbers correct the rules, so that a large error moves them by no more than that.
- The rules that fire at a sample are corrected with its own error, for the next time they fire.
- A rule goes no further than the command's limit: else it would wind up where that stops.
- Its M, the gain of the machine, is 1 there: another one is another ``gamma``.
"""

from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

from hfc_design.controllers.controller import AxisLaw, Signals, stood
from hfc_design.controllers.neighbours import Degrees, changed, evenly, weighted
from hfc_design.core.numbers import Scalar, Xp, clipped

#: The sets of an input are -HIGHEST to HIGHEST.
HIGHEST = 5
SETS = 2 * HIGHEST + 1
LABELS = [f"{place:+d}" if place else "0" for place in range(-HIGHEST, HIGHEST + 1)]
#: (11, 11) commands before ``gu``, rows by the error and columns by its change, from -5 to 5.
Rules: TypeAlias = Sequence[Sequence[Scalar]]


class SocGains(NamedTuple):
    """What is searched, on errors and commands in the units of the drive."""

    ge: Scalar  # sets per unit of the error [1/error]
    gc: Scalar  # sets per unit of its change in a sample [1/error]
    gu: Scalar  # command for a rule of 1 [command]
    gamma: Scalar  # share of the error that a correction removes [1]
    xi: Scalar  # weight of the change in it, that of the error is 1 - xi [1]


class SocMemory(NamedTuple):
    """What the controller remembers."""

    error: Scalar  # e(k-1)
    rules: Rules


class Parts(NamedTuple):
    """What a command is made of."""

    error: Scalar  # in sets
    change: Scalar  # in sets
    in_error: Sequence[Scalar]  # (11,) degrees
    in_change: Sequence[Scalar]  # (11,)
    rules: Rules  # as they act in this sample
    inferred: Scalar  # what they give


def soc(rules: Rules, sample_time: float, limit: float | None = None) -> AxisLaw:
    """The law that begins with ``rules``."""
    return AxisLaw(sample, initial_memory, sample_time, limit, rules, tells=True, prime=stood)


def initial_memory(law: AxisLaw, zero: Scalar) -> SocMemory:
    """Memory before the first sample: the axis stood on its reference."""
    return SocMemory(zero, [[zero + rule for rule in row] for row in law.structure])


def sample(
    xp: Xp, law: AxisLaw, gains: SocGains, memory: SocMemory, signals: Signals
) -> tuple[Scalar, SocMemory, Parts]:
    """The command of one sample: ``u = gu sum(w_i U_i)`` over the four rules that fire.

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
    """(11,) degrees of a value in the sets: linear between two neighbours, which add up to 1."""
    return evenly(xp, value, HIGHEST)
