"""PD plus a hierarchy of two-input fuzzy units (Lin & Lee 1999, section 3.2).

One unit has linguistic terms, a singleton rule table and centre-average defuzzification. Written
for scalars and unrolled: inside the closed loop an array of seven memberships would cost a factor
of five. ``xp`` as in ``core.numbers``. Never imports JAX.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import NamedTuple, TypeAlias

from hfc_design.controllers.controller import AxisLaw, Signals
from hfc_design.controllers.hierarchical import root as root_unit
from hfc_design.controllers.hierarchical.tree import Sources
from hfc_design.core.numbers import Degrees, Floats, RuleTable, Scalar, Xp, clipped, dot, total

#: What gives the degrees of a scalar in the terms.
Graded: TypeAlias = Callable[[Scalar], list[Scalar]]
#: (root's table at first, degrees of the column, of the row) -> it as it is by now, its memory.
Learnt: TypeAlias = Callable[[RuleTable, Degrees, Degrees], tuple[RuleTable, root_unit.RootMemory]]
#: An input of this prefix is the reading of the previous sample, 0 at the first one.
PREVIOUS = "previous_"
#: The input that adds up the error [unit of the error times s], within its universe.
INTEGRAL = "error_integral"
#: Inputs of Lin & Lee 1999, section 4, with their scales k_1 to k_5.
LIN_LEE_INPUTS = {
    "error": 50.0,
    "deflection": 80.0,
    "deflection_rate": 20.0,
    "spindle_velocity": 20.0,
    "previous_spindle_velocity": 10.0,
}


class Term(NamedTuple):
    """A linguistic term on the normalised universe: a Gaussian with a flat top.

    Lin & Lee 1999, eq. 3. It is MATLAB's ``gauss2mf`` and fuzzylite's ``GaussianProduct`` with
    shoulders at ``centre -/+ half_width`` and sigma = 1/sqrt(2 rate).
    """

    label: str
    centre: float
    half_width: float
    rate: float


#: The seven terms of every input in Lin & Lee 1999 (eq. 3a-3g).
LIN_LEE_TERMS: tuple[Term, ...] = (
    Term("f1", -1.0, 0.1, 4.0),
    Term("f2", -0.6, 0.05, 8.0),
    Term("f3", -0.2, 0.0, 32.0),
    Term("f4", 0.0, 0.0, 32.0),
    Term("f5", 0.2, 0.0, 32.0),
    Term("f6", 0.6, 0.05, 8.0),
    Term("f7", 1.0, 0.1, 4.0),
)


class Layout(NamedTuple):
    """What the search leaves alone: which inputs, which terms they have, how the output counts.

    The defaults are those of Lin & Lee 1999, section 4.
    """

    inputs: tuple[str, ...] = tuple(LIN_LEE_INPUTS)
    output_scale: float = 10.0  # k_6 [V]
    terms: tuple[Term, ...] = LIN_LEE_TERMS
    adaptation: root_unit.Adaptation | None = None  # of the root's consequents; None: fixed

    @property
    def remembered(self) -> tuple[str, ...]:
        """Readings that are needed a sample later."""
        found = (name for name in self.inputs if name.startswith(PREVIOUS))
        return tuple(name.removeprefix(PREVIOUS) for name in found)


class HierarchicalGains(NamedTuple):
    """What the search changes: one individual, or a population in the trailing axis."""

    kp: Scalar  # [V/rad]
    kd: Scalar  # [V s/rad]
    scales: Sequence[Scalar] | Floats  # (inputs,) k_1, k_2, ..., per unit of the input
    sources: Sources  # (units,) column and row source, see ``tree.Tree``
    consequents: Sequence[RuleTable] | Floats  # (units, 7, 7) singletons [unit][row][column]


class HierarchicalMemory(NamedTuple):
    """What the controller remembers; all zero before the first sample."""

    readings: Mapping[str, Scalar]  # of the previous sample
    root: root_unit.RootMemory | None  # None: the root does not adapt
    integral: Scalar | None = None  # of the error; None: nothing reads it


class Firing(NamedTuple):
    """What one unit does at a sample."""

    column: Scalar  # its inputs, an input of the hierarchy clamped to [-1, 1]
    row: Scalar
    in_column: Degrees  # (7,) degrees
    in_row: Degrees  # (7,)
    table: RuleTable  # (7, 7) consequents [row][column] as they are at this sample
    output: Scalar


class HierarchyParts(NamedTuple):
    """What the command is made of."""

    readings: list[Scalar]  # of each input
    scaled: list[Scalar]
    units: list[Firing]
    proportional: Scalar
    derivative: Scalar
    fuzzy: Scalar  # the root's output, scaled


def membership(xp: Xp, term: Term, u: Scalar) -> Scalar:
    """Degree in (0, 1] to which scalar ``u`` belongs to ``term``."""
    distance = u - term.centre
    if term.half_width:
        outside = abs(distance) - term.half_width
        distance = xp.where(outside > 0.0, outside, 0.0)
    return xp.decay((-term.rate * distance) * distance)


def memberships(xp: Xp, terms: Sequence[Term], u: Scalar) -> list[Scalar]:
    """Degrees of scalar ``u`` in every term."""
    return [membership(xp, term, u) for term in terms]


def averaged(xp: Xp, consequents: RuleTable, in_column: Degrees, in_row: Degrees) -> Scalar:
    """Output of one unit from the degrees of its two inputs (LL eq. 4).

    ``consequents[i][j]`` is the singleton of the rule "row is term i and column is term j".
    Singleton fuzzifier, product, centre average. Where no rule fires (an input so far outside
    the universe that every membership underflows) the output is 0.
    """
    weighted = 0.0
    for degree, singletons in zip(in_row, consequents, strict=True):
        weighted = weighted + degree * dot(in_column, singletons)
    firing = total(in_column) * total(in_row)
    # The division comes last: what ends in a division the compiler computes once, what ends in
    # a selection it would repeat in everything that uses it.
    return xp.ratio(weighted, xp.where(firing > 0.0, firing, 1.0))


def hierarchical(layout: Layout, sample_time: float, limit: float | None = None) -> AxisLaw:
    """The law of kind ``pd+hierarchical-fuzzy``."""
    return AxisLaw(sample, initial_memory, sample_time, limit, layout, tells=True)


def initial_memory(law: AxisLaw, zero: Scalar) -> HierarchicalMemory:
    """Memory before the first sample."""
    layout: Layout = law.structure
    root = root_unit.initial_memory(zero) if layout.adaptation else None
    integral = zero if INTEGRAL in layout.inputs else None
    return HierarchicalMemory(dict.fromkeys(layout.remembered, zero), root, integral)


def sample(
    xp: Xp, law: AxisLaw, gains: HierarchicalGains, memory: HierarchicalMemory, signals: Signals
) -> tuple[Scalar, HierarchicalMemory, HierarchyParts]:
    """The command of one sample (LL eq. 6), what to remember, and what it is made of.

    The scaled external inputs are clamped to [-1, 1]; the outputs of inner units are not,
    because published consequents lie outside that range.
    """
    layout: Layout = law.structure
    known = {**signals, **{f"{PREVIOUS}{name}": x for name, x in memory.readings.items()}}
    integral = memory.integral
    if integral is not None:
        # Held at the edge of its universe, beyond which it would change nothing but wind up.
        edge = xp.ratio(1.0, gains.scales[layout.inputs.index(INTEGRAL)])
        integral = clipped(xp, integral + law.sample_time * signals["error"], -edge, edge)
        known[INTEGRAL] = integral
    readings = [known[name] for name in layout.inputs]
    scaled = [scale * x for x, scale in zip(readings, gains.scales, strict=True)]
    values = [clipped(xp, u, -1.0, 1.0) for u in scaled]
    degrees = partial(memberships, xp, layout.terms)
    learnt = _learning(xp, layout, gains, memory, signals["error"])
    units, root = outputs(xp, degrees, gains, values, learnt)
    proportional, derivative = gains.kp * signals["error"], gains.kd * signals["error_rate"]
    fuzzy = layout.output_scale * units[-1].output
    parts = HierarchyParts(readings, scaled, units, proportional, derivative, fuzzy)
    remembered = {name: signals[name] for name in layout.remembered}
    command = proportional + derivative + fuzzy
    return command, HierarchicalMemory(remembered, root, integral), parts


def _learning(
    xp: Xp, layout: Layout, gains: HierarchicalGains, memory: HierarchicalMemory, error: Scalar
) -> Learnt | None:
    """What makes the root's table what it is by now; None where the root does not adapt."""
    adaptation = layout.adaptation
    if adaptation is None or memory.root is None:
        return None
    scale = adaptation.error_scale
    if scale is None:
        scale = gains.scales[layout.inputs.index("error")]
    graded = memberships(xp, layout.terms, clipped(xp, scale * error, -1.0, 1.0))
    return partial(root_unit.step, xp, adaptation, memory.root, graded)


def outputs(
    xp: Xp,
    degrees: Graded,
    gains: HierarchicalGains,
    inputs: Sequence[Scalar],
    learnt: Learnt | None = None,
) -> tuple[list[Firing], root_unit.RootMemory | None]:
    """What every unit makes of the clamped ``inputs``, the root last, and what it remembers."""
    values, units, remembered = list(inputs), [], None
    last = len(gains.consequents) - 1
    for k, ((column, row), start) in enumerate(zip(gains.sources, gains.consequents, strict=True)):
        seen = xp.pick(values, column), xp.pick(values, row)
        in_column, in_row = (degrees(u) for u in seen)
        own = learnt(start, in_column, in_row) if learnt and k == last else (start, None)
        table, remembered = own
        values.append(averaged(xp, table, in_column, in_row))
        units.append(Firing(*seen, in_column, in_row, table, values[-1]))
    return units, remembered
