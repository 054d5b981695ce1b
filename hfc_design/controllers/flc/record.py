"""Records of the two-input fuzzy controller in design files and scenarios. Never imports JAX."""

from collections.abc import Iterable
from itertools import pairwise
from math import inf, isinf
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self

from pydantic import AfterValidator, Field, ValidationInfo, field_validator, model_validator

from hfc_design.controllers.controller import AxisLaw
from hfc_design.controllers.flc.law import Compensation, FlcGains, flc
from hfc_design.controllers.flc.rules import FEWEST, LABELS, MOST, RulesRecord, unused_term
from hfc_design.controllers.kind import (
    CHANGES,
    ControllerRecord,
    ControllerSettings,
    DeadZone,
    Target,
    controller_named,
    dead_zone_note,
    later,
    sampled_otherwise,
)
from hfc_design.core.numbers import Json, Parameters, Plain, Triangles
from hfc_design.core.records import Finite, Label, NotNegative, Ordered, Positive, Record
from hfc_design.stability.sectors import centred, sectors_at_centres, true_sectors

Variable = Literal["error", "error_change", "output"]


class NamesRecord(Record):
    """Names of the variables, and of the whole system."""

    error: Label = "error"  # name of the error in exported files
    error_change: Label = "error_change"  # name of the change of the error in exported files
    output: Label = "rules"  # name of the output of the rules in exported files
    #: name of the whole system in exported files; left out: the name of the output
    engine: Label | None = Field(None, exclude_if=lambda name: name is None)

    @model_validator(mode="after")
    def _differ(self) -> Self:
        names = [name.casefold() for name in (self.error, self.error_change, self.output)]
        if twice := next((name for name in names if names.count(name) > 1), None):
            needed = f"must have different names (got {twice} twice)"
            raise ValueError(f"error, error_change and output {needed}")
        return self


#: Default names of the variables.
USUAL = NamesRecord()


def called(name: str, usual: str, meaning: str) -> str:
    """Return the text for a variable: ``meaning``, or "name (meaning)" if its name is unusual."""
    return meaning if name in (usual, meaning) else f"{name} ({meaning})"


def signals_of(names: NamesRecord) -> dict[str, str]:
    """Return name -> signal of the inputs that do not have the usual names."""
    pairs = (names.error, USUAL.error), (names.error_change, USUAL.error_change)
    return {name: signal for name, signal in pairs if name != signal}


def _rising(ends: tuple[float, float]) -> tuple[float, float]:
    if not ends[0] < ends[1]:
        raise ValueError(f"must be an ascending range (got {ends[0]} to {ends[1]})")
    return ends


#: Ranges of the variables in exported files, in BLU and units of the command; they change no
#: command.
Ranges = dict[Variable, Annotated[tuple[Finite, Finite], AfterValidator(_rising)]]


if TYPE_CHECKING:
    from plants import Drive  # which imports JAX

#: Length of a BLU [mm] unless a design gives another.
BLU_MM = 0.01


class TriangleRecord(Record):
    """One linguistic term: a triangle (JK04 eq. 1). An edge that is null or left out is infinite.

    An edge can be left out because TOML has no null.
    """

    label: Label  # name of the term
    left: Finite | None = None  # left end [BLU]; left out: unbounded
    centre: Finite  # centre, where it is 1 [BLU]
    right: Finite | None = None  # right end [BLU]; left out: unbounded

    def edges(self) -> tuple[float, float, float]:
        """Return left, centre and right; unbounded edges are infinite."""
        left = -inf if self.left is None else self.left
        return left, self.centre, inf if self.right is None else self.right


Terms = Annotated[tuple[TriangleRecord, ...], Field(min_length=FEWEST, max_length=MOST)]
#: Keys of the terms of both inputs, that of the rows of the table first.
SIDES = ("error_terms", "error_change_terms")


def terms_of(triangles: Triangles, labels: Iterable[str]) -> Terms:
    """Return terms from triangles (left, centre, right), lowest first, without validation."""
    return tuple(
        TriangleRecord.model_construct(
            label=label,
            left=None if isinf(left) else left,
            centre=centre,
            right=None if isinf(right) else right,
        )
        for label, (left, centre, right) in zip(labels, triangles, strict=True)
    )


class CompensationRecord(Record):
    """Low-velocity compensation in units of the command (JK04 eq. 28-30), V in mm/s."""

    #: coefficients of V^2, V and 1 for V >= 0 in mm/s [command]
    forward: tuple[Finite, Finite, Finite]
    backward: tuple[Finite, Finite, Finite]  # the same for V < 0 [command]
    highest_velocity_mm_s: Positive  # speed from which on nothing is compensated [mm/s]
    breakaway: tuple[Finite, Finite]  # command at rest towards + and towards - [command]
    smallest_error: Positive  # error below which an axis at rest is not moved [BLU]
    blu_mm: Positive = Field(BLU_MM, exclude_if=BLU_MM.__eq__)  # length of a BLU [mm]


class FuzzyRecord(ControllerRecord):
    """Common base of the three fuzzy kinds."""

    error_terms: Terms  # triangles of the error, in order
    error_change_terms: Terms  # triangles of the change of the error in a sample, in order
    #: rule table: a row for each term of the error, a column for each term of its change
    rules: RulesRecord
    integral_gain: Finite  # gain on the integral of the error [units/(BLU s)]
    #: friction that is compensated at low speed; left out: none
    low_velocity: CompensationRecord | None = None
    dead_zone: DeadZone = 0.0  # errors up to this count as 0 [BLU]
    #: names of inputs and output in exported files
    names: NamesRecord = Field(NamesRecord(), exclude_if=NamesRecord().__eq__)
    #: ranges of the variables in exported files [BLU, command]; no effect on commands
    ranges: Ranges = Field({}, exclude_if=lambda ranges: not ranges)
    adapts: ClassVar[bool] = False

    rule_base = later(".export", "RULES")
    explain = later(".export", "EXPLAIN")
    widths = later(".export", "widths")
    pictures = later(".section", "pictures")
    sections = later(".section", "table_sections")

    @model_validator(mode="after")
    def _has_no_gap(self) -> "FuzzyRecord":
        for key, terms in self.sides.items():
            if fault := terms_fault(terms):
                raise ValueError(f"{key}: {fault}")
        rows, columns = map(len, self.sides.values())
        if (shape := self.rules.shape()) != (rows, columns):
            message = f"has {shape[0]} x {shape[1]} entries; {rows} error_terms and {columns}"
            needed = f"error_change_terms need {rows} x {columns}"
            raise ValueError(f"rules.centroids: {message} {needed}")
        return self

    @property
    def sides(self) -> dict[str, Terms]:
        """Terms of the error and of its change, by their keys."""
        return {key: getattr(self, key) for key in SIDES}

    @classmethod
    def renewed(cls, data: Json, keys: list[str]) -> None:
        """Remove labels if numbers changed; with output terms, numbers if labels changed."""
        rules = data.get("rules")
        if isinstance(rules, dict):
            if fault := unused_term(rules, keys):
                raise ValueError(fault)
            changed_keys = {key.split(".")[1] for key in keys if key.startswith("rules.")}
            sides = ["labels", "centroids"]
            source, other = sides if rules.get("output_terms") else sides[::-1]
            if changed_keys & {source, "output_terms"} and other not in changed_keys:
                rules.pop(other)

    def at_first(self) -> Self:
        """Return the controller as it is in its first sample."""
        return self

    def control_form(self) -> str:
        """Return the form of JK95 eq. 1; it is "PD" unless an ``flc`` sets another."""
        return "PD"

    def reads(self) -> list[str]:
        """Signals that the controller reads in a sample."""
        return ["error", "velocity"] if self.low_velocity else ["error"]

    def on(self, drive: "Drive", parameters: Parameters) -> Self:
        """Return the design with the length of a BLU that the ``drive`` has."""
        if self.low_velocity is None or drive.millimetres is None:
            return self
        low = self.low_velocity.model_copy(update={"blu_mm": drive.millimetres(parameters)})
        return self.model_copy(update={"low_velocity": low})

    def input_range(self, limit: float | None) -> dict[str, float]:
        """Return ranges: outermost centres [BLU], and the highest compensated velocity [BLU/s]."""
        farthest = [max(abs(term.centre) for term in terms) for terms in self.sides.values()]
        ranges = dict(zip(("error", "error_change"), farthest, strict=True))
        if low := self.low_velocity:
            ranges["velocity"] = low.highest_velocity_mm_s / low.blu_mm
        return ranges

    def connecting(self) -> list[str]:
        """Return notes on how the controller processes its signals."""
        notes = [] if self.control_form() == "P" else [CHANGES]
        notes += dead_zone_note(self)
        if low := self.low_velocity:
            highest = low.highest_velocity_mm_s / low.blu_mm
            description = f"not of the reference; from {highest!r} upwards nothing is compensated"
            notes.append(f"`velocity` is that of the axis and {description}.")
        return notes

    def table(self) -> FlcGains:
        """Return the numbers of the fuzzy controller, as those of one individual."""
        error, change = (tuple(term.edges() for term in x) for x in self.sides.values())
        return FlcGains(
            error,
            change,
            self.rules.centroids,
            self.integral_gain,
            Compensation(**dict(self.low_velocity)) if self.low_velocity else None,
            self.dead_zone or None,
        )

    def table_gains(self) -> dict[str, tuple[float, float]]:
        """Gains (K_1, K_2) of the rule table [unit/BLU], by the method that found them."""
        table = self.table()[:3]
        by_method = {"table, with its edges": true_sectors(*table)}
        if all(map(centred, table[:2])):
            by_method = {"table, eq. 13 and 14": sectors_at_centres(*table), **by_method}
        return {name: (sectors.k1, sectors.k2) for name, sectors in by_method.items()}


class FlcDesign(FuzzyRecord):
    """Design of kind ``flc``; ``form`` as in JK95 eq. 1."""

    kind: Literal["flc"] = "flc"
    summary = "two-input fuzzy controller with an integral term (Jee & Koren 1995, 2004)"
    settings = later(".record", "FlcSettings")
    genome = later(".genome", "FuzzyGenome")
    sections = later(".section", "sections")
    #: P: the error only; PI: the output of the table is summed; PD: the output is the command
    form: Literal["P", "PI", "PD"] = "PD"

    @field_validator("rules")
    @classmethod
    def _labels_fit(cls, rules: RulesRecord) -> RulesRecord:
        if fault := rules.contradiction():
            raise ValueError(fault)
        return rules

    def law_gains(self) -> FlcGains:
        """Return the gains of the design, as those of one individual."""
        return self.table()

    def law(self, limit: float | None) -> AxisLaw:
        """Return the law of one axis."""
        return flc(self.form, self.sample_time_s, limit)

    def control_form(self) -> str:
        """Return the form of the design."""
        return self.form


def terms_fault(terms: Terms) -> str | None:
    """Return a message on what is wrong with the terms of an input; None if nothing is."""
    labels = [term.label for term in terms]
    if fault := _labels_fault(labels):
        return fault
    for k, term in enumerate(terms):
        if (term.left is None) != (k == 0) or (term.right is None) != (k == len(terms) - 1):
            ends = f"left of {labels[0]} and right of {labels[-1]}"
            return f"{term.label}: an edge must be null {ends}, and only there"
    for term in terms:
        left, centre, right = term.edges()
        if not left < centre < right:
            return f"{term.label}: left, centre, right = {left}, {centre}, {right}: must ascend"
    for low, high in pairwise(terms):
        (_, lower, right), (left, upper, _) = low.edges(), high.edges()
        if right <= left:
            return f"gap between {low.label} (right end {right}) and {high.label} (left end {left})"
        if not (lower <= left and right <= upper):
            edges = f"the edges between {low.label} and {high.label}"
            return f"{edges} must not pass the other's centre"
    return None


def _labels_fault(labels: list[str]) -> str | None:
    usual = [label for label in labels if label in LABELS]
    if usual != sorted(set(usual), key=LABELS.index):
        return f"must have the labels {', '.join(LABELS)} in this order"
    folded = [label.casefold() for label in labels]
    twice = next((x for x in labels if folded.count(x.casefold()) > 1), None)
    also = "or names that differ only in case"
    return f"terms must have different names (got {twice} twice, {also})" if twice else None


class FuzzySettings(Ordered, ControllerSettings):
    """Settings of a search for a fuzzy controller: the design to start from, and bounds."""

    keys_last = ("kind",)
    start: Any  # design that the search starts from: a built-in name, a file, or a record
    symmetric: bool = True  # whether the controller acts alike in both directions
    #: largest integral gain of the search [units/(BLU s)]
    largest_integral_gain: NotNegative = 8.0

    @field_validator("start", mode="before")
    @classmethod
    def _controller_of(cls, start: Plain, info: ValidationInfo) -> Plain:
        """Return the controller of the design named by ``start``; records are returned as given."""
        return controller_named(start, info)

    def fault(self, target: Target) -> str | None:
        """Return why the search is impossible (no feed drive, or unfit start), or None."""
        for drive in target.machine.drives:
            if drive.linear is None:
                unfit = f"needs a feed drive (got {drive.name})"
                return f"controller.kind = {self.kind!r}: {unfit}"
        if fault := sampled_otherwise(self.start, target):
            return fault
        for key, terms in self.start.sides.items():
            middle = terms[len(terms) // 2]
            if len(terms) % 2 == 0:
                reason = f"as a search keeps the middle one on 0 (got {len(terms)})"
                return f"controller.start: must have an odd number of {key}, {reason}"
            if middle.centre != 0.0:
                place = f"on 0, where a search keeps it (got {middle.centre})"
                return f"controller.start: {middle.label} of its {key} must be centred {place}"
        return None


class FlcSettings(FuzzySettings):
    """Settings of a search for an ``flc`` of a feed drive."""

    kind: Literal["flc"]
    #: design that the search starts from: a built-in name, a file, or a record
    start: FlcDesign = Field("jee-koren-2004-flc", validate_default=True)
