"""Records of PD plus a fuzzy hierarchy in a design file, and settings of a search for one.

Never imports JAX.
"""

from operator import add, not_
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from hfc_design.controllers.controller import FOLLOWED, AxisLaw
from hfc_design.controllers.hierarchical.law import (
    LIN_LEE_INPUTS,
    LIN_LEE_TERMS,
    PREVIOUS,
    HierarchicalGains,
    HierarchicalMemory,
    Layout,
    hierarchical,
    term,
)
from hfc_design.controllers.hierarchical.root import Adaptation
from hfc_design.controllers.hierarchical.tree import MAX_INPUTS, notation, reachable
from hfc_design.controllers.kind import ControllerSettings, Target, input_ranges, later
from hfc_design.controllers.linear.record import (
    FILTERS,
    FeedForwardRecord,
    FilteredRecord,
    LinearDesign,
    LqiSettings,
    Range,
    Resonators,
    too_fast,
    with_own_signals,
)
from hfc_design.core.numbers import each
from hfc_design.core.records import TERMS, Finite, Label, NotNegative, Positive, Record, Rules
from hfc_design.core.wording import one_of


class PdRecord(Record):
    """Gains of the PD part (LL eq. 6)."""

    kp: Finite  # gain on the error [command/error]
    kd: Finite  # gain on the rate of the error [command s/error]


class LinearRecord(Record):
    """Linear part without kp and kd: integral, state feedback, feed-forward, resonators."""

    ki: Finite = 0.0  # gain on the integral of the error [command/(error s)]
    signals: dict[Label, Finite] = {}  # gains on signals of the drive's sensors [command/signal]
    feed_forward: FeedForwardRecord = FeedForwardRecord()  # feed-forward gains
    resonators: Resonators = Field((), exclude_if=not_)  # one for each frequency of a periodic load

    _signals_fit = model_validator(mode="after")(with_own_signals)


class ScheduledRecord(LinearRecord):
    """Linear law that the scaled output of the root multiplies."""

    kp: Finite = 0.0  # gain on the error [command/error]
    kd: Finite = 0.0  # gain on the rate of the error [command s/error]


class LinearPart(LqiSettings):
    """Settings of a search for a linear part: an optimal regulator with integral."""

    kind: Literal["lqi"] = "lqi"


class InputRecord(Record):
    """Input of the hierarchy: a signal, and the scale that brings it into the range -1 to 1."""

    name: Label  # signal that is read
    scale: Positive  # factor on the signal [1/signal]; the product is limited to -1 to 1


Inputs = Annotated[tuple[InputRecord, ...], Field(min_length=2, max_length=MAX_INPUTS)]


class TermRecord(Record):
    """Linguistic term: a Gaussian with a flat top (LL eq. 3)."""

    label: Label  # name of the term
    centre: Finite  # centre of the flat top, as a value of a scaled input [1]
    half_width: NotNegative  # half the width of the flat top [1]
    rate: Positive  # c of exp(-c d^2), d the distance from the flat top [1]


Terms = Annotated[tuple[TermRecord, ...], Field(min_length=TERMS, max_length=TERMS)]


class UnitRecord(Record):
    """Fuzzy unit: its number, its two inputs and its 7 x 7 consequents [row][column]."""

    #: number of the unit; units are listed in the order of evaluation, the root last
    id: int = Field(ge=0, le=1000)
    #: input of the columns: a signal, or unit-N for the output of unit N
    column_input: Label | Annotated[str, Field(pattern=r"^unit-\d{1,4}$")]
    #: input of the rows: a signal, or unit-N for the output of unit N
    row_input: Label | Annotated[str, Field(pattern=r"^unit-\d{1,4}$")]
    consequents: Rules  # output of each rule [1]; rows and columns in the order of the terms


def _with_error_scale(described: Any) -> Any:
    """Return ``described``; ValueError if an adaptation lacks a scale of the error."""
    adaptation, names = described.adaptation, [item.name for item in described.inputs]
    some = getattr(described, "used", None)
    if adaptation and adaptation.error_scale is None and (some or "error" not in names):
        unless = "it may be left out only if an input named error is always read"
        raise ValueError(f"adaptation.error_scale: is missing; {unless}")
    return described


class HierarchicalDesign(FilteredRecord):
    """Design of kind ``pd+hierarchical-fuzzy``; units in evaluation order, the root last."""

    kind: Literal["pd+hierarchical-fuzzy"] = "pd+hierarchical-fuzzy"
    summary = "PD plus a hierarchy of two-input fuzzy units (Lin & Lee 1999)"
    settings = later(".record", "HierarchicalSettings")
    genome = later(".scheduled_genome", "genome_of")
    units_that_matter = later(".units", "units_that_matter")
    reads = later(".rules", "reads")
    rule_base = later(".rules", "RULES")
    explain = later(".rules", "EXPLAIN")
    lookup = later(".code", "tabulated")
    pictures = later(".pictures", "pictures")
    sections = later(".section", "sections")
    pd: PdRecord  # gains of the PD, LL eq. 6
    #: further linear gains in addition to kp and kd; left out: only a PD
    linear: LinearRecord | None = Field(None, exclude_if=not_)
    #: linear law that the scaled output of the root multiplies; left out: none
    scheduled: ScheduledRecord | None = Field(None, exclude_if=not_)
    inputs: Inputs  # signals that the hierarchy reads, with their scales
    output_scale: Positive  # command for an output of 1 of the root [command]
    terms: Terms  # seven linguistic terms of every input, in order
    #: two-input fuzzy units, at most five
    units: Annotated[tuple[UnitRecord, ...], Field(min_length=1, max_length=5)]
    #: adaptation of the root's table in the loop; left out: none
    adaptation: Adaptation | None = Field(None, exclude_if=not_)

    @model_validator(mode="after")
    def _schedules_beside_a_linear_part(self) -> "HierarchicalDesign":
        if self.scheduled and not self.linear:
            raise ValueError("scheduled: needs a linear part, whose integral it shares")
        if self.filters and not self.linear:
            raise ValueError("notch_hz, lowpass_hz: need a linear part, whose memory they share")
        return self

    @model_validator(mode="after")
    def _resonates_as_samples_can(self) -> "HierarchicalDesign":
        laws = [law for law in (self.linear, self.scheduled) if law]
        first, *others = [[x.frequency_rad_s for x in law.resonators] for law in laws] or [[]]
        if fault := too_fast(first, self.sample_time_s):
            raise ValueError(f"linear.resonators: {fault}")
        if others not in ([], [first]):
            raise ValueError("scheduled.resonators: must have the frequencies of linear.resonators")
        return self

    @model_validator(mode="after")
    def _is_a_tree(self) -> "HierarchicalDesign":
        waiting = [item.name for item in self.inputs]
        if len(set(waiting)) < len(waiting):
            raise ValueError(f"inputs: must have different names, repeated: {', '.join(waiting)}")
        if len({term_record.label for term_record in self.terms}) < TERMS:
            raise ValueError("terms: must have different labels")
        for unit in self.units:
            for source in (unit.column_input, unit.row_input):
                if source not in waiting:
                    needed = "must be an input or an earlier unit that no other unit reads"
                    raise ValueError(f"units: unit {unit.id} reads {source!r}, which {needed}")
                waiting.remove(source)
            waiting.append(f"unit-{unit.id}")
        if lost := [x for x in waiting[:-1] if x.startswith("unit-")]:  # inputs may be unread
            unread = f"nothing reads {', '.join(lost)}"
            raise ValueError(f"units: must all be read, except the root; {unread}")
        return self

    _can_adapt = model_validator(mode="after")(_with_error_scale)

    def law(self, limit: float | None) -> AxisLaw:
        """Return the law of one axis."""
        return hierarchical(layout_of(self), self.sample_time_s, limit)

    def adapted(self, memory: HierarchicalMemory) -> "HierarchicalDesign | None":
        """Return the design with the moves of the root in ``memory``; None if it does not adapt."""
        if self.adaptation is None or memory.root is None:
            return None
        moves = tuple(map(tuple, memory.root.moves))
        adaptation = self.adaptation.model_copy(update={"moves": moves})
        return self.model_copy(update={"adaptation": adaptation})

    def without_adaptation(self) -> Self:
        """Return the design without adaptation, with the root as adapted so far."""
        pairs = zip(self.units, self.tables(), strict=True)
        units = tuple(unit.model_copy(update={"consequents": table}) for unit, table in pairs)
        return self.model_copy(update={"units": units, "adaptation": None})

    def tables(self) -> list[Rules]:
        """Return the consequents of each unit; those of the root as adapted so far."""
        tables = [unit.consequents for unit in self.units]
        if self.adaptation and (moves := self.adaptation.moves):
            tables[-1] = tuple(map(tuple, each(add, tables[-1], moves)))
        return tables

    def sources(self) -> list[tuple[int, int]]:
        """Return column source and row source of each unit, numbered as in the module ``tree``."""
        names = [item.name for item in self.inputs] + [f"unit-{unit.id}" for unit in self.units]
        return [
            (names.index(unit.column_input), names.index(unit.row_input)) for unit in self.units
        ]

    def structure(self) -> str:
        """Return the tree as ``Genome.notation`` writes it; "" if there is one unit."""
        if len(self.units) == 1:
            return ""
        return notation([item.name for item in self.inputs], self.sources())

    @property
    def canonical(self) -> bool:
        """True if every source of every unit is one that this unit has in any of ``tree.trees``."""
        known = reachable(len(self.inputs), len(self.units) + 1)
        pairs = zip(self.sources(), known, strict=True)
        return all(a in columns and b in rows for (a, b), (columns, rows) in pairs)

    def law_gains(self) -> HierarchicalGains:
        """Return the gains of the design, as those of one individual."""
        return HierarchicalGains(
            self.pd.kp,
            self.pd.kd,
            tuple(item.scale for item in self.inputs),
            tuple(self.sources()),
            tuple(unit.consequents for unit in self.units),
            part.law_gains() if (part := self.linear_part) else None,
            part.law_gains() if (part := self.scheduled_part) else None,
        )

    def input_range(self, limit: float | None) -> dict[str, float]:
        """Return ranges of signals: of inputs up to saturation, of others those of linear laws."""
        ranges: dict[str, float] = {}
        for part in (self.scheduled_part, self.linear_part):
            ranges |= part.input_range(limit or self.output_scale) if part else {}
        ranges |= input_ranges({"error": self.pd.kp, "error_rate": self.pd.kd}, self.output_scale)
        inputs = sorted(self.inputs, key=lambda item: -item.scale)  # the widest last: it counts
        return ranges | {item.name.removeprefix(PREVIOUS): 1.0 / item.scale for item in inputs}

    def connecting(self) -> list[str]:
        """Return notes on filtering and on previous readings kept inside the controller."""
        names = [item.name for item in self.inputs if item.name.startswith(PREVIOUS)]
        before = "is that of the previous sample, and remembered inside"
        notes = [f"`{name}` {before}: nothing needs to be connected." for name in names]
        return ["`error_rate` is not filtered inside.", *notes]

    @property
    def linear_part(self) -> LinearDesign | None:
        """Linear part with kp and kd, as a controller of its own; None if there is only a PD."""
        filters = {key: getattr(self, key) for names in FILTERS.values() for key in names}
        return self._alone("linear part", self.linear, self.pd, **filters) if self.linear else None

    @property
    def scheduled_part(self) -> LinearDesign | None:
        """Law that the root's output multiplies, as a controller of its own; None: no such law."""
        return self._alone("scheduled part", self.scheduled) if self.scheduled else None

    def _alone(self, kind: str, *records: Record, **filters: Any) -> LinearDesign:
        data = {key: x for one in records for key, x in one.model_dump().items()}
        return LinearDesign(kind=kind, sample_time_s=self.sample_time_s, **data, **filters)


class HierarchicalSettings(ControllerSettings):
    """Settings of a search for a hierarchical fuzzy controller: inputs, scales and terms."""

    kind: Literal["pd+hierarchical-fuzzy"] = "pd+hierarchical-fuzzy"
    #: signals that a hierarchy may read, with their scales
    inputs: Inputs = tuple(InputRecord(name=k, scale=x) for k, x in LIN_LEE_INPUTS.items())
    output_scale: Positive = 10.0  # command for an output of 1 of the root [command]
    #: seven linguistic terms of every input, in order
    terms: Terms = tuple(TermRecord(**published_term._asdict()) for published_term in LIN_LEE_TERMS)
    #: adaptation of the root's table in the loop; left out: none
    adaptation: Adaptation | None = None
    #: linear law added to the hierarchy; left out: only a PD
    linear: LinearPart | None = Field(None, exclude_if=not_)
    #: number of inputs that a hierarchy reads; the search chooses which; left out: all
    used: Annotated[int, Field(ge=2, le=MAX_INPUTS)] | None = Field(None, exclude_if=not_)
    #: whether the root scales a second linear law; needs controller.linear
    schedules: bool = Field(False, exclude_if=not_)

    _can_adapt = model_validator(mode="after")(_with_error_scale)

    @model_validator(mode="after")
    def _has_so_many(self) -> "HierarchicalSettings":
        most = len(self.inputs)
        if self.used and self.used > most:
            raise ValueError(f"used must be at most {most}, the inputs (got {self.used})")
        return self

    @property
    def staged(self) -> bool:
        """True with a linear part: stages search regulator weights, gains, then everything."""
        return self.linear is not None

    def fault(self, target: Target) -> str | None:
        """Return why the search is impossible (linear part, moves, unfit inputs), or None."""
        if self.schedules and not self.linear:
            return "controller.schedules: needs [controller.linear], which it changes"
        if self.adaptation and self.adaptation.moves:
            return "controller.adaptation.moves: must be left out, they belong to a design"
        if self.linear and (linear_fault := self.linear.fault(target)):
            return linear_fault.replace("controller.", "controller.linear.", 1)
        names = [item.name for item in self.inputs]
        for drive in target.machine.drives:
            known = input_names(drive.inputs)
            for name in names:
                if name not in known:
                    unknown = f"unknown signal of the {drive.name}; {one_of(name, known)}"
                    return f"controller.inputs: {name!r}: {unknown}"
                if names.count(name) > 1:
                    return f"controller.inputs: {name!r} is listed twice"
        return None


def layout_of(described: HierarchicalDesign | HierarchicalSettings) -> Layout:
    """Return the ``Layout`` of a design, or of a search for one."""
    names = tuple(item.name for item in described.inputs)
    terms = tuple(term(**term_record.model_dump()) for term_record in described.terms)
    scale, adaptation = described.output_scale, described.adaptation
    if isinstance(described, HierarchicalSettings):
        return Layout(names, scale, terms, described.used, adaptation)
    laws = (described.linear_part, described.scheduled_part)
    part, scheduled_form = (None if law is None else law.form for law in laws)
    used, canonical = len(described.units) + 1, described.canonical
    return Layout(names, scale, terms, used, adaptation, part, scheduled_form, canonical)


class Bounds(Record):
    """Bounds of a search for hierarchies: keys of ``[search]``, with defaults for the C-axis."""

    #: range of kp of initial individuals with a hierarchy [command/error]
    kp_range: Range = (100.0, 10_000.0)
    kd_range: Range = (30.0, 3_000.0)  # range of kd of initial individuals [command s/error]
    #: largest factor between first and given scales of a hierarchy's inputs [1]; 1: fixed
    scale_range: float = Field(10.0, ge=1)
    inner_limit: float = Field(4.0, gt=0, le=4)  # largest |consequent| of inner units [1]
    root_limit: Positive = 20.0  # largest |consequent| of a hierarchy's root [1]


def bounds_of(search: Any) -> Bounds:
    """Return the bounds in the validated settings ``search``; defaults for those that it lacks."""
    return Bounds.model_construct(**dict(search or {}))


def input_names(signals: list[str]) -> list[str]:
    """Return every possible input of a hierarchy on an axis with these signals."""
    known = [*signals, *(x for x in FOLLOWED if x not in signals)]
    return [*known, *(f"{PREVIOUS}{name}" for name in known)]
