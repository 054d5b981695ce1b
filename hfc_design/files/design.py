"""The design file: a controller as data that other programs read. Never imports JAX."""

import json
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    Field,
    JsonValue,
    SerializerFunctionWrapHandler,
    Tag,
    model_serializer,
    model_validator,
)

from hfc_design.controllers.flc.record import FeedDesign
from hfc_design.controllers.gains.law import LAWS, Law
from hfc_design.controllers.hierarchical.root import Adaptation
from hfc_design.core.dotted import Changes, changed
from hfc_design.core.records import (
    BUILT_IN,
    OWN,
    TERMS,
    Finite,
    Name,
    NotNegative,
    Positive,
    Record,
    Table,
    UserError,
    by_kind,
    checked,
)

#: The designs that come with the package.
BUILTIN = Path(__file__).parent / "designs"

LawName = Annotated[Name, AfterValidator(LAWS.checked)]
Label = Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]{0,31}$")]


class PlantRecord(Record):
    """The machine that the controller was designed for."""

    name: Name
    parameters: dict[str, Finite]
    axes: dict[Label, dict[str, Finite]] = {}  # what differs in each axis, if there are several


class PdRecord(Record):
    """Gains of LL eq. 6."""

    kp: Finite  # [V/rad]
    kd: Finite  # [V s/rad]


class InputRecord(Record):
    """One input of the hierarchy and its scale to the normalised universe."""

    name: Label
    scale: Positive


class TermRecord(Record):
    """One linguistic term: a Gaussian with a flat top (LL eq. 3)."""

    label: Label
    centre: Finite
    half_width: NotNegative
    rate: Positive


class UnitRecord(Record):
    """One unit: its place in the heap, its two inputs and its 7 x 7 singletons [row][column]."""

    id: int = Field(ge=0, le=1000)
    column_input: Label | Annotated[str, Field(pattern=r"^unit-\d{1,4}$")]
    row_input: Label | Annotated[str, Field(pattern=r"^unit-\d{1,4}$")]
    consequents: Table


class AdaptationRecord(Record):
    """How the root's consequents adapt on line, see ``laws.root_unit``."""

    k_c: NotNegative = 3e-4  # step of a consequent in a sample
    largest_move: Positive  # of a consequent from where it started
    error_scale: Positive | None = None  # [1/unit of error]; None: that of the input error

    def law(self) -> Adaptation:
        """The same as numbers."""
        return Adaptation(self.k_c, self.largest_move, self.error_scale)


def check_adaptation(adaptation: AdaptationRecord | None, inputs: Iterable[InputRecord]) -> None:
    """Whether the error that judges the root's rules has a scale.

    Raises:
        ValueError: it has none.
    """
    if adaptation is None or adaptation.error_scale is not None:
        return
    if "error" not in [item.name for item in inputs]:
        raise ValueError(
            "adaptation.error_scale: is missing, and no input is named error whose scale could "
            "stand for it"
        )


class PdDesign(Record):
    """A controller of kind ``pd``."""

    kind: Literal["pd"] = "pd"
    sample_time_s: Positive
    pd: PdRecord


class HierarchicalDesign(Record):
    """A controller of kind ``pd+hierarchical-fuzzy``; units in evaluation order, the root last."""

    kind: Literal["pd+hierarchical-fuzzy"] = "pd+hierarchical-fuzzy"
    sample_time_s: Positive
    pd: PdRecord
    inputs: Annotated[tuple[InputRecord, ...], Field(min_length=2, max_length=6)]
    output_scale: Positive
    terms: Annotated[tuple[TermRecord, ...], Field(min_length=TERMS, max_length=TERMS)]
    units: Annotated[tuple[UnitRecord, ...], Field(min_length=1, max_length=5)]
    adaptation: AdaptationRecord | None = None  # of the root; None: its table stays

    @model_serializer(mode="wrap")
    def _without_what_is_absent(self, whole: SerializerFunctionWrapHandler) -> dict[str, Any]:
        data: dict[str, Any] = whole(self)
        if adaptation := data.pop("adaptation", None):
            data["adaptation"] = {k: v for k, v in adaptation.items() if v is not None}
        return data

    @model_validator(mode="after")
    def _is_a_tree(self) -> "HierarchicalDesign":
        waiting = [item.name for item in self.inputs]
        if len(set(waiting)) < len(waiting):
            raise ValueError(f"inputs: a name stands there twice: {', '.join(waiting)}")
        if len({term.label for term in self.terms}) < TERMS:
            raise ValueError("terms: a label stands there twice")
        for unit in self.units:
            for source in (unit.column_input, unit.row_input):
                if source not in waiting:
                    raise ValueError(
                        f"units: unit {unit.id} reads {source!r}, which is not an input or an "
                        "earlier unit whose value is still free"
                    )
                waiting.remove(source)
            waiting.append(f"unit-{unit.id}")
        if waiting != [f"unit-{self.units[-1].id}"]:
            raise ValueError(f"units: nothing reads {', '.join(waiting[:-1])}")
        check_adaptation(self.adaptation, self.inputs)
        return self

    def sources(self) -> list[tuple[int, int]]:
        """Column and row source of each unit, as ``hierarchy.Unit`` numbers them."""
        names = [item.name for item in self.inputs] + [f"unit-{unit.id}" for unit in self.units]
        return [
            (names.index(unit.column_input), names.index(unit.row_input)) for unit in self.units
        ]


class LawDesign(Record):
    """A controller of a user's own kind, see ``laws.law``."""

    kind: LawName
    sample_time_s: Positive
    gains: dict[Label, Finite]

    @model_validator(mode="after")
    def _known(self) -> "LawDesign":
        wanted = self.law.ranges._fields
        if set(self.gains) != set(wanted):
            raise ValueError(f"gains: has to hold {', '.join(wanted)} and nothing else")
        return self

    @property
    def law(self) -> Law:
        """The law that the gains are for."""
        return LAWS.get(self.kind)

    def values(self) -> Any:
        """The law's record of gains."""
        return type(self.law.ranges)(**self.gains)


BuiltInDesign = PdDesign | HierarchicalDesign | FeedDesign


class Design(Record):
    """A design file as a whole."""

    format: Literal["hfc-design"] = "hfc-design"
    version: Literal[1] = 1
    name: Name
    plant: PlantRecord
    controller: Annotated[
        Annotated[BuiltInDesign, Field(discriminator="kind"), Tag(BUILT_IN)]
        | Annotated[LawDesign, Tag(OWN)],
        by_kind(*LAWS.built_in),
    ]
    score: dict[str, JsonValue] = {}
    provenance: dict[str, JsonValue] = {}


def builtin_designs() -> list[str]:
    """Names of the designs that come with the package."""
    found = BUILTIN.iterdir()
    return sorted(entry.name.removesuffix(".json") for entry in found if entry.name[0] != "_")


def named_design(name: str) -> Design:
    """The design with a built-in name, in a file or in a run folder.

    Raises:
        UserError: there is no such design, or the file is not one that can run.
    """
    if name in builtin_designs():
        text = (BUILTIN / f"{name}.json").read_text()
        return parse_design(text, name)
    if not Path(name).exists():
        known = ", ".join(builtin_designs())
        raise UserError(f"{name}: no such design; built in are {known}, or give a design file")
    return read_design(Path(name) / "design.json" if Path(name).is_dir() else Path(name))


def read_design(path: str | Path) -> Design:
    """The design in a file.

    Raises:
        UserError: the file cannot be read, is no JSON, or is not a design that can run.
    """
    try:
        text = Path(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise UserError(f"{path}: cannot be read: {error}") from None
    return parse_design(text, path)


def parse_design(text: str, source: str | Path) -> Design:
    """The design in ``text``; ``source`` stands in the messages.

    Raises:
        UserError: text is no JSON, or is not a design that can run.
    """
    try:
        data = json.loads(text, parse_constant=_refused)
    except (ValueError, RecursionError) as error:
        raise UserError(f"{source}: is not a whole JSON file: {error}") from None
    return checked(Design, data, source, Path(source).parent)


def changed_design(design: Design, changes: Changes, source: str) -> Design:
    """The design with other values of dotted keys, noted in its provenance; its score is gone.

    Raises:
        UserError: a change is not of that form, or what comes out cannot run.
    """
    data = changed(design.model_dump(mode="json"), changes, "--change")
    told = dict(changes) if isinstance(changes, Mapping) else list(changes)
    data |= {"score": {}, "provenance": data["provenance"] | {"changes": told}}
    return checked(Design, data, f"{source}, changed", Path(source).parent)


def _refused(name: str) -> Any:
    raise ValueError(f"{name} is no number that a design may hold")


def design_json(design: Design) -> str:
    """The design as JSON; every float reads back bit for bit, a row of a table is a line."""
    text = json.dumps(design.model_dump(mode="json"), indent=1, allow_nan=False)
    rows = re.compile(r'\[[\s\d.,eE+-]+\]|\[\s*"[A-Z]{2}"[\s,"A-Z]+\]')
    return rows.sub(
        lambda row: re.sub(r"\s+", " ", row[0]).replace("[ ", "[").replace(" ]", "]"), text
    )
