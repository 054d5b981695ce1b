"""PD plus a hierarchy of two-input fuzzy units (Lin & Lee 1999, section 3.2).

Each unit has linguistic terms, a rule table of singletons (the consequents) and centre-average
defuzzification. The functions compute with scalars, term by term: arrays of seven degrees would
make the closed loop five times slower. ``xp`` is explained in ``core.numbers``. Never imports JAX.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from operator import mul
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from hfc_design.controllers.controller import AxisLaw, Signals
from hfc_design.controllers.hierarchical import root as root_unit
from hfc_design.controllers.hierarchical.tree import Reach, Sources, reachable
from hfc_design.controllers.linear import law as linear
from hfc_design.controllers.linear.law import LinearGains, LinearMemory, Parts, Structure
from hfc_design.core.numbers import Constant, Degrees, Floats, RuleTable, Scalar, Xp, clipped, total

#: Function that returns the degrees of a scalar in the terms.
Graded: TypeAlias = Callable[[Scalar], list[Scalar]]
#: Function (designed table of the root, degrees of column, degrees of row) -> (table, memory).
Learnt: TypeAlias = Callable[[RuleTable, Degrees, Degrees], tuple[RuleTable, root_unit.RootMemory]]
#: Prefix of the name of an input that is a signal's reading of the previous sample.
PREVIOUS = "previous_"
#: Inputs of Lin & Lee 1999, section 4, with their scales k_1 to k_5.
LIN_LEE_INPUTS = {
    "error": 50.0,
    "deflection": 80.0,
    "deflection_rate": 20.0,
    "spindle_velocity": 20.0,
    "previous_spindle_velocity": 10.0,
}


class Term(NamedTuple):
    """Linguistic term of a scaled input: a Gaussian with a flat top.

    Lin & Lee 1999, eq. 3. In MATLAB it is ``gauss2mf``, in fuzzylite ``GaussianProduct``, with the
    top from ``centre - half_width`` to ``centre + half_width`` and sigma = 1/sqrt(2 rate).
    """

    label: str
    centre: Constant
    half_width: Constant
    rate: Constant


def term(label: str, centre: float, half_width: float, rate: float) -> Term:
    """Return a term whose numbers are compiled in, as exponentials take most of a sample's time."""
    return Term(label, Constant(centre), Constant(half_width), Constant(rate))


#: The seven terms of every input in Lin & Lee 1999 (eq. 3a-3g).
LIN_LEE_TERMS: tuple[Term, ...] = (
    term("f1", -1.0, 0.1, 4.0),
    term("f2", -0.6, 0.05, 8.0),
    term("f3", -0.2, 0.0, 32.0),
    term("f4", 0.0, 0.0, 32.0),
    term("f5", 0.2, 0.0, 32.0),
    term("f6", 0.6, 0.05, 8.0),
    term("f7", 1.0, 0.1, 4.0),
)


class Grid(NamedTuple):
    """Degrees at evenly spaced values, for code without ``exp``."""

    low: float  # the lowest value
    per_unit: float  # number of values in an interval of length 1
    table: tuple[tuple[float, ...], ...]  # (points, 7)


def tabulated(xp: Xp, grid: Grid, u: Scalar) -> Sequence[Scalar]:
    """Return the degrees (7,) of ``u`` from a grid: linear between points, constant beyond."""
    last = len(grid.table) - 1
    if isinstance(u, np.ndarray):  # in the precision of u, as for single values
        places = np.clip((u - grid.low) * grid.per_unit, 0.0, last)
        below = np.clip(np.nan_to_num(places), 0, last - 1).astype(int)
        rises, rows = np.diff(grid.table, axis=0).astype(u.dtype), np.array(grid.table, u.dtype)
        return [*(rows[below].T + (places - below.astype(u.dtype)) * rises[below].T)]
    table = xp.table(grid.table)
    place = clipped(xp, (u - grid.low) * grid.per_unit, 0.0, float(last))
    k = xp.minimum(xp.whole(place), last - 1)
    part = place - k
    return xp.along(lambda lower, upper: lower + part * (upper - lower), table[k], table[k + 1])


class Layout(NamedTuple):
    """Properties of a hierarchy that no search varies: inputs, terms, scale of the output.

    The defaults are those of Lin & Lee 1999, section 4.
    """

    inputs: tuple[str, ...] = tuple(LIN_LEE_INPUTS)
    output_scale: float = 10.0  # k_6 [V]
    terms: tuple[Term, ...] = LIN_LEE_TERMS
    used: int | None = None  # number of inputs that are read; None: all
    adaptation: root_unit.Adaptation | None = None  # of the root's consequents; None: fixed
    linear: Structure | None = None  # the linear part; None: a PD alone
    #: Law that the scaled output of the root multiplies; None: the root gives a command.
    scheduled: Structure | None = None
    canonical: bool = True  # whether each unit reads sources that it has in ``tree.trees``
    grid: Grid | None = None  # lookup table of degrees, in the runtime only; None: exact terms

    def graded(self, xp: Xp) -> Graded:
        """Return the function from a number to its degrees in the terms."""
        if self.grid:
            return partial(xp.call, tabulated, xp, self.grid)
        return partial(xp.call, memberships, xp, self.terms)

    @property
    def input_range(self) -> Reach:
        """Possible sources of the column input and of the row input of each unit."""
        count = len(self.inputs)
        if self.canonical:
            return reachable(count, self.used)
        return [(range(count + k), range(count + k)) for k in range((self.used or count) - 1)]

    @property
    def remembered(self) -> tuple[str, ...]:
        """Names of the signals whose readings are needed a sample later."""
        previous = (name for name in self.inputs if name.startswith(PREVIOUS))
        return tuple(name.removeprefix(PREVIOUS) for name in previous)


class HierarchicalGains(NamedTuple):
    """Numbers that a search varies: of one individual, or of a population along the last axis."""

    kp: Scalar  # [V/rad]
    kd: Scalar  # [V s/rad]
    scales: Sequence[Scalar] | Floats  # (inputs,) factors k_1, k_2, ... [1/input]
    sources: Sources  # (units,) column and row source, see ``tree.Tree``
    consequents: Sequence[RuleTable] | Floats  # (units, 7, 7) singletons [unit][row][column]
    linear: LinearGains | None = None  # linear part, kp and kd included; None: a PD alone
    scheduled: LinearGains | None = None  # law that the root's output multiplies


class HierarchicalMemory(NamedTuple):
    """Memory of the controller; before the first sample all zero, except for moves of the root."""

    root: root_unit.RootMemory | None  # None: the root does not adapt
    readings: Mapping[str, Scalar]  # signals of the previous sample, by name
    linear: LinearMemory | None = None  # None: a PD remembers nothing


class Firing(NamedTuple):
    """Inputs, degrees, table and output of one unit at a sample."""

    column: Scalar  # column input; an input of the hierarchy is clamped to [-1, 1]
    row: Scalar  # row input, likewise
    in_column: Degrees  # (7,) degrees of the column input
    in_row: Degrees  # (7,) degrees of the row input
    table: RuleTable  # (7, 7) consequents [row][column] as they are at this sample
    output: Scalar


class HierarchyParts(NamedTuple):
    """Parts of a command."""

    readings: list[Scalar]  # (inputs,) unscaled inputs
    scaled: list[Scalar]  # (inputs,) scaled inputs, not clamped
    units: list[Firing]
    proportional: Scalar
    derivative: Scalar
    fuzzy: Scalar  # the root's scaled output, times the scheduled law if there is one
    linear: Parts | None = None  # of the linear part, proportional and derivative among them
    scheduled: Parts | None = None  # of the scheduled law, before the root multiplies it


def membership(xp: Xp, term: Term, u: Scalar) -> Scalar:
    """Return the degree in (0, 1] to which scalar ``u`` belongs to ``term``."""
    distance = u - term.centre
    if term.half_width:
        outside = abs(distance) - term.half_width
        distance = xp.where(outside > 0.0, outside, 0.0)
    return xp.bell(term.rate, distance)


def memberships(xp: Xp, terms: Sequence[Term], u: Scalar) -> list[Scalar]:
    """Return the degrees of scalar ``u`` in every term."""
    return [membership(xp, term, u) for term in terms]


def averaged(xp: Xp, consequents: RuleTable, in_column: Degrees, in_row: Degrees) -> Scalar:
    """Return the output of one unit from the degrees (7,) of its two inputs (LL eq. 4).

    ``consequents[i][j]`` is the singleton of the rule "row is term i and column is term j".
    The output is the average of the singletons, weighted by the products of the degrees. It is 0
    if no rule fires: if an input is so far outside [-1, 1] that every degree rounds to 0.
    """

    def weigh(degree: Scalar, row: Sequence[Scalar]) -> Scalar:
        return degree * xp.total(xp.along(mul, in_column, row))

    weighted = xp.total(xp.along(weigh, in_row, consequents))
    firing = xp.total(in_column) * xp.total(in_row)
    # The division comes last: the compiler computes a quotient once, but computes the result of a
    # ``where`` again in every expression that uses it.
    return xp.ratio(weighted, xp.where(firing > 0.0, firing, 1.0))


def hierarchical(layout: Layout, sample_time: float, limit: float | None = None) -> AxisLaw:
    """Return the law of kind ``pd+hierarchical-fuzzy``."""
    tells = layout.linear is None
    return AxisLaw(sample, initial_memory, sample_time, limit, layout, tells, primed)


def initial_memory(law: AxisLaw, zero: Scalar) -> HierarchicalMemory:
    """Return the memory before the first sample."""
    layout: Layout = law.structure
    learnt = layout.adaptation
    root = root_unit.initial_memory(zero, learnt.moves) if learnt else None
    part = law._replace(structure=layout.linear)
    linear_memory = None if layout.linear is None else linear.initial_memory(part, zero)
    return HierarchicalMemory(root, dict.fromkeys(layout.remembered, zero), linear_memory)


def primed(
    xp: Xp, law: AxisLaw, gains: HierarchicalGains, memory: HierarchicalMemory, signals: Signals
) -> HierarchicalMemory:
    """Return the memory with the readings of this sample as those of the previous sample."""
    return memory._replace(readings={name: signals[name] for name in memory.readings})


def sample(
    xp: Xp, law: AxisLaw, gains: HierarchicalGains, memory: HierarchicalMemory, signals: Signals
) -> tuple[Scalar, HierarchicalMemory, HierarchyParts]:
    """Return the command of one sample (LL eq. 6), the memory after it, and the command's parts.

    The scaled external inputs are clamped to [-1, 1]; the outputs of inner units are not,
    because published consequents lie outside that range.
    """
    layout: Layout = law.structure
    known = {**signals, **{f"{PREVIOUS}{name}": x for name, x in memory.readings.items()}}
    readings = [known[name] for name in layout.inputs]
    scaled = [scale * x for x, scale in zip(readings, gains.scales, strict=True)]
    values = [clipped(xp, u, -1.0, 1.0) for u in scaled]
    learnt = _learning(xp, layout, gains, memory, signals["error"])
    units, root = outputs(xp, layout.graded(xp), layout.input_range, gains, values, learnt)
    fuzzy = layout.output_scale * units[-1].output
    remembered = {name: signals[name] for name in layout.remembered}
    if layout.linear is None:
        parts = (gains.kp * signals["error"], gains.kd * signals["error_rate"], fuzzy)
        whole = HierarchyParts(readings, scaled, units, *parts)
        return total(parts), HierarchicalMemory(root, remembered), whole
    assert gains.linear is not None
    assert memory.linear is not None
    before, error = memory.linear, signals["error"]
    part = law._replace(structure=layout.linear)
    straight, rate, linear_parts = linear.commanded(xp, part, gains.linear, before, signals)
    steps, bent, scheduled = [linear.driven(part, gains.linear, error)], fuzzy, None
    if layout.scheduled is not None:
        # The root multiplies a linear law instead of the number k_6 of LL eq. 6.
        own_gains: Any = gains.scheduled
        law_of_root = law._replace(structure=layout.scheduled)
        nothing = before._replace(integral=0.0 * straight, resonators=(), filters=())
        other, _, scheduled = linear.commanded(xp, law_of_root, own_gains, nothing, signals)
        bent = fuzzy * other
        steps.append(linear.driven(law_of_root, own_gains, error, fuzzy))
    filtered = linear.filtered(part, gains.linear, before, straight + bent, linear_parts)
    command, before, linear_parts = filtered
    after = linear.remembered(xp, part, command, before, rate, *steps)
    shares = (linear_parts.proportional, linear_parts.derivative, bent, linear_parts, scheduled)
    whole = HierarchyParts(readings, scaled, units, *shares)
    return command, HierarchicalMemory(root, remembered, after), whole


def _learning(
    xp: Xp, layout: Layout, gains: HierarchicalGains, memory: HierarchicalMemory, error: Scalar
) -> Learnt | None:
    """Return the function that adapts the root's table; None if the root does not adapt."""
    adaptation = layout.adaptation
    if adaptation is None or memory.root is None:
        return None
    scale = adaptation.error_scale
    if scale is None:
        scale = gains.scales[layout.inputs.index("error")]
    graded = layout.graded(xp)(clipped(xp, scale * error, -1.0, 1.0))
    return partial(root_unit.step, xp, adaptation, memory.root, graded)


def outputs(
    xp: Xp,
    degrees: Graded,
    source_options: Reach,
    gains: HierarchicalGains,
    inputs: Sequence[Scalar],
    learnt: Learnt | None = None,
) -> tuple[list[Firing], root_unit.RootMemory | None]:
    """Return the firing of every unit for clamped ``inputs``, root last, and the root's memory."""
    values, units, remembered = list(inputs), [], None
    last = len(gains.consequents) - 1
    for k, (sources, start) in enumerate(zip(gains.sources, gains.consequents, strict=True)):
        pairs = zip(source_options[k], sources, strict=True)
        column, row = (xp.pick({n: values[n] for n in free}, source) for free, source in pairs)
        in_column, in_row = degrees(column), degrees(row)
        unit_state = learnt(start, in_column, in_row) if learnt and k == last else (start, None)
        table, remembered = unit_state
        values.append(xp.sure(xp.call(averaged, xp, table, in_column, in_row)))
        units.append(Firing(column, row, in_column, in_row, table, values[-1]))
    return units, remembered
