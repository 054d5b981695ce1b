"""The design file: a controller as data for other programs. Never imports JAX."""

import json
import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from operator import not_
from os.path import exists
from pathlib import Path
from shlex import quote
from typing import Annotated, Any, Literal, Self

from pydantic import Field, JsonValue, SerializeAsAny, ValidationError, model_validator

from hfc_design.controllers.controller import Controller, rate_limited, within_rate
from hfc_design.controllers.kind import ControllerRecord, require
from hfc_design.controllers.kinds import KINDS
from hfc_design.controllers.per_axis import learnt
from hfc_design.core.arguments import a_kind
from hfc_design.core.embedded_files import embedded, embedder
from hfc_design.core.numbers import Json, Memory, finite
from hfc_design.core.overrides import Changes, lists, overridden, set_keys
from hfc_design.core.plugins import chosen, naming_modules, resuming, uses
from hfc_design.core.records import (
    Asked,
    Finite,
    Label,
    Name,
    NotNegative,
    Positive,
    Record,
    UserError,
    checked,
)
from hfc_design.core.tables import line, table
from hfc_design.core.texts import as_user_error, json_of, no_such, read_text, toml_of, writable
from hfc_design.core.validation_errors import inside

#: The designs that come with the package.
BUILTIN = Path(__file__).parent / "designs"
#: Endings of files of other programs, which ``hfc import`` converts to designs.
IMPORTED = (".fll", ".fis", ".fcl", ".fml")


class PerAxisRecord(Record):
    """Settings of every axis; ``axes`` has the values that differ for one of them."""

    #: values that differ in one axis, by its name, with the same keys
    axes: dict[Label, dict[str, JsonValue]] = Field({}, exclude_if=not_)

    @model_validator(mode="after")
    def _axes_fit(self) -> Self:
        for axis in self.axes:
            try:
                self.of(axis)
            except ValidationError as error:
                raise inside(error, "axes", axis) from None
        return self

    def of(self, axis: str) -> Self:
        """Return the settings of one axis: the common ones, with those of ``axes`` for it."""
        axis_settings = self.axes.get(axis)
        if axis_settings is None:
            return self
        every = {key: getattr(self, key) for key in self.model_fields_set - {"axes"}}
        return type(self)(**every | axis_settings)


#: Largest delay of a command [samples].
MOST_DELAYED = 64.0


class Limits(PerAxisRecord):
    """Limits of the drives' commands, in the units of the plant, and steps of their converters.

    A command is limited to ``command``, changes no faster than ``command_rate`` [1/s], from 0
    before the first sample, and is then rounded to ``resolution``, the step of the converter. It
    acts ``delay_samples`` later (1 if the control computes while the last command acts), and the
    drive's current follows it with ``lag_s``. A controller applies only the first two itself.
    """

    #: largest command in both directions [command]; left out: only the limit of the drive
    command: Positive | None = None
    #: largest rate of the command, starting from 0 [command/s]; left out: unlimited
    command_rate: Positive | None = Field(None, exclude_if=not_)
    #: step of the converter; 0: ideal [command]
    resolution: NotNegative = Field(0.0, exclude_if=not_)
    #: delay of the command [samples]; 1: it acts in the next sample, as with computing time;
    #: fractions act in the mean over a sample
    delay_samples: Annotated[NotNegative, Field(le=MOST_DELAYED)] = Field(0.0, exclude_if=not_)
    #: time constant of the current loop of the drive [s]
    lag_s: NotNegative = Field(0.0, exclude_if=not_)

    @model_validator(mode="after")
    def _has_steps(self) -> Self:
        if self.command is not None and self.resolution > self.command:
            raise ValueError(
                f"resolution = {self.resolution}: must be at most command = {self.command}"
            )
        return self

    def commands(self, axes: Iterable[str]) -> dict[str, float | None]:
        """Return the largest command of each of these axes; None: no limit."""
        return {axis: self.of(axis).command for axis in axes}

    def changes(self, axes: Iterable[str], sample_time: float) -> dict[str, float | None]:
        """Return the largest change of the command of each axis in a sample; None: no limit."""
        rates = {axis: self.of(axis).command_rate for axis in axes}
        return {axis: rate and rate * sample_time for axis, rate in rates.items()}

    def other_than(self, *used: str) -> Json:
        """Return values by full keys (limits.KEY), but neither the keys ``used`` nor defaults."""
        left = self.model_dump(exclude={"axes", *used}, exclude_defaults=True)
        return {f"limits.{key}": x for key, x in left.items()}

    def without_rate(self) -> Self:
        """Return the same limits, but without ``command_rate``."""
        axes = {
            axis: {key: x for key, x in axis_limits.items() if key != "command_rate"}
            for axis, axis_limits in self.axes.items()
        }
        return self.model_copy(update={"command_rate": None, "axes": axes})


class PlantRecord(Record):
    """The machine that the controller was designed for."""

    name: Name  # name of the plant
    parameters: dict[str, Finite]  # all parameters of the plant [of the parameter]
    #: values that differ in each axis, if there are several [of the parameter]
    axes: dict[Label, dict[str, Finite]] = {}


#: Table of a file that is for information only: nothing computes with it.
Told = Annotated[dict[str, JsonValue], writable]


class Design(Record, metaclass=Asked):
    """A design file as a whole."""

    format: Literal["hfc-design"] = "hfc-design"  # identifies a design file
    version: Literal[1] = 1  # version of the format
    name: Name  # name of the design
    plant: PlantRecord  # machine that it was designed for
    #: the controller; its keys are those of its kind
    controller: Annotated[SerializeAsAny[ControllerRecord], chosen(KINDS, "record")]
    #: limits applied by the controller itself; left out: none
    limits: Limits = Field(Limits(), exclude_if=Limits().__eq__)
    score: Told = {}  # score when it was made; for information only
    #: origin; for information only
    provenance: Annotated[Told, naming_modules] = {}
    _axis: str = ""
    _connected: Any = None  # see ``formats.connection``

    def __repr__(self) -> str:
        return line("Design", self._summary())

    __str__ = __repr__

    def _repr_html_(self) -> str:
        return table("Design", self._summary() | self.score)

    def _summary(self) -> dict[str, object]:
        controller = self.controller
        fields = {"name": self.name, "plant": self.plant.name, "kind": controller.kind}
        return {**fields, "sample_time_s": controller.sample_time_s}

    @property
    def kind(self) -> type[ControllerRecord]:
        """Kind of the controller."""
        return type(self.controller)

    @property
    def failed(self) -> bool:
        """True if the score in the file says that the motion diverged."""
        return self.score.get("fitness", "") is None

    @property
    def axis(self) -> str:
        """Axis whose part of a design this is; "" for a whole design."""
        return self._axis

    @property
    def connected(self) -> Any:
        """Connection of its code to a machine's sensors; None: the code reads the law's signals."""
        return self._connected

    def commanding(self, axes: Iterable[str]) -> Controller:
        """Return the controller of a machine with these axes, within the limits of this design.

        Raises:
            UserError: the controller is not one for such a machine.
        """
        if self._connected and self._connected.machine:
            return self._connected.machine
        limits = self.limits.commands(axes := tuple(axes))
        controller = self.controller.controller_of(limits)
        return rate_limited(controller, limits, self.changes(axes))

    def changes(self, axes: Iterable[str]) -> dict[str, float | None]:
        """Return the largest change of the command of each axis in a sample; None: no limit."""
        return self.limits.changes(axes, self.controller.sample_time_s)

    def by_axis(self) -> dict[str, "Design"]:
        """Return designs of single axes by name, or {"": this design} if all axes have the same.

        Also {"": this design} if the controller commands the whole machine.
        """
        if self.kind.controller and not self.kind.axis_records:
            return {"": self}
        records = self.controller.axis_records() if self.kind.axis_records else {}
        names = list(records) or (list(self.plant.axes) if self.limits.axes else [])
        designs = {}
        for axis in names:
            axis_fields = {
                "controller": records.get(axis, self.controller),
                "limits": self.limits.of(axis),
            }
            designs[axis] = self.model_copy(update={"name": f"{self.name}-{axis}", **axis_fields})
            designs[axis]._axis = axis
        return designs or {"": self}


#: A design, or what stands for one: a built-in name, a file, a run folder.
AnyDesign = Design | str | Path


def builtin_designs() -> list[str]:
    """Return the names of the designs that come with the package."""
    return sorted(path.stem for path in BUILTIN.glob("*.json"))


def named_design(source: AnyDesign) -> Design:
    """Return the design with a built-in name, in a file or in a run folder; or a design as it is.

    Raises:
        UserError: there is no such design, or the file does not hold a design that can run.
    """
    if isinstance(source, Design):
        return source
    if not isinstance(source, str | Path):
        raise UserError(
            f"argument must be a design or the name of one (got {a_kind(source)}){_inside(source)}"
        )
    name, path = str(source), Path(source)
    if name in builtin_designs():
        return parse_design(read_text(BUILTIN / f"{name}.json"), name)
    if not exists(path):
        raise no_such("design", name, builtin_designs())
    if path.is_dir() and exists(path / "batch.json"):
        raise UserError(
            f"{name}: is the folder of a batch, not of a design; name one of its runs "
            "(hfc report FOLDER lists them), or draw their searches: hfc plot FOLDER "
            "convergence"
        )
    if path.is_dir() and not exists(path := path / "design.json"):
        raise UserError(f"{name}: has no finished run (no design.json); {resuming(path.parent)}")
    return read_design(path)


def _inside(thing: Any) -> str:
    """Return an end for a message: advice, if ``thing`` is a result that has a design, else ""."""
    return "; give its .design" if isinstance(getattr(thing, "design", None), Design) else ""


def read_design(path: str | Path) -> Design:
    """Read the design in a file; files that its scenario names are embedded if they lie beside it.

    Raises:
        UserError: the file cannot be read, is not JSON, or is not a design that can run.
    """
    if Path(path).suffix.lower() in IMPORTED:
        command = f"hfc import {quote(Path(path).as_posix())} --out NAME.json"
        raise UserError(f"{path}: is a controller of another program; convert it with {command}")
    design = parse_design(read_text(path), path)
    named = design.provenance.get("scenario")
    scenario = embedded(named, Path(path).parent, embedder())
    if scenario == named:
        return design
    return design.model_copy(update={"provenance": design.provenance | {"scenario": scenario}})


def parse_design(text: str, source: str | Path) -> Design:
    """Parse the design in ``text`` from ``source``; UserError: it is not JSON, or cannot run."""
    with as_user_error(source):
        data = _json_of(text)
    provenance = data.get("provenance") if isinstance(data, dict) else None
    with naming(provenance):
        return checked(Design, data, source, Path(source).parent)


def _json_of(text: str) -> Any:
    try:
        return json_of(text)
    except ValueError as error:
        try:
            toml = toml_of(text)
        except ValueError:
            toml = {}
        fault = (
            "is a TOML file, as of a scenario, not a design; to design a controller for "
            "it run hfc design"
        )
        raise (ValueError(fault) if toml else error) from None


@contextmanager
def naming(provenance: Any) -> Iterator[None]:
    """Add to a UserError the plug-ins that a design's provenance names, and that are not known."""
    try:
        yield
    except UserError as error:
        named = provenance.get("plugins") if isinstance(provenance, dict) else None
        needed = uses(named, known=False)
        if not needed:
            raise
        first, *others = error.args
        raise UserError(f"{first}; its provenance names{needed}", *others) from None


def changed_design(design: Design, changes: Changes, source: str) -> Design:
    """Return the design with other values of dotted keys, noted in its provenance, without score.

    Raises:
        UserError: a change is not KEY=VALUE, or is not allowed, or the result cannot run.
    """
    values = changes if isinstance(changes, Mapping) else set_keys(changes, "change")
    data = overridden(design.model_dump(mode="json"), values, "change")
    start = "controller."
    controller_keys = [key.removeprefix(start) for key in values if key.startswith(start)]
    if controller_keys and isinstance(data["controller"], dict):
        try:
            design.controller.renewed(data["controller"], controller_keys)
        except ValueError as error:
            raise UserError(f"{source}, changed: {start}{error}") from None
    recorded: Any = list(changes)
    if isinstance(changes, Mapping):  # nan and inf as texts: an error then names their own key
        recorded = {key: x if finite(x) else repr(x) for key, x in lists(dict(changes)).items()}
    data["score"] = {}
    if isinstance(data["provenance"], dict):  # otherwise ``checked`` refuses it
        data["provenance"]["changes"] = recorded
    return checked(Design, data, f"{source}, changed", Path(source).parent)


def design_json(design: Design) -> str:
    """Return the design as JSON: floats are read back bit for bit; a row of a table is a line."""
    text = json.dumps(design.model_dump(mode="json"), indent=1, allow_nan=False)
    return _ROWS.sub(lambda match: match["text"] or _flat(match[0]), text)


#: A text, which is kept; or what becomes a line: a list of numbers, or of labels within a list.
_ROWS = re.compile(
    r'(?P<text>"(?:[^"\\]|\\.)*+")|\[[\s\d.,eE+-]++\]|(?<=\s\s)\[\s*"\w++"(?:,\s*"\w++")*+\s*\]'
)


def _flat(row: str) -> str:
    return " ".join(row.split()).replace("[ ", "[").replace(" ]", "]")


#: End of the name of a design that has learned; largest length of a name.
ENDING, LONGEST = "-learned", 64


def learned(design: Design, axes: Iterable[str], memory: Memory, origin: Json) -> Design:
    """Return the design with the values that the ``memory`` of its controller has learned.

    ``axes`` are those of the machine: if they have learned different values, each gets a controller
    of its own. ``origin`` is for the provenance.

    Raises:
        UserError: the controller does not adapt, or a number of its memory is not finite.
    """
    if not finite(memory):
        raise UserError(f"design {design.name}: has diverged; its learned state cannot be kept")
    controller = learnt(design.controller, tuple(axes), within_rate(memory))
    return with_learned(design, require(controller, design, "it does not adapt"), origin)


def with_learned(design: Design, controller: ControllerRecord, origin: Json) -> Design:
    """Return the design with a ``controller`` that has learned, without score.

    Raises:
        UserError: the new design is not one that can run.
    """
    name = design.name.removesuffix(ENDING)[: LONGEST - len(ENDING)] + ENDING
    data = design.model_dump(mode="json", exclude={"score", "controller"})
    data |= {"name": name, "controller": controller.model_dump(mode="json")}
    data["provenance"] |= {"learned": {"from": design.name, **origin}}
    return checked(Design, data, f"learned state of {design.name}", Path())
