"""Kinds of controller: the base class with everything that the rest of the package calls.

A kind is a folder beside this file; ``KIND`` in its ``__init__`` registers it, ``KINDS`` several.
Never imports JAX.
"""

import importlib
from collections.abc import Callable
from types import FunctionType
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, NamedTuple, Self, get_args

from pydantic import Field, ValidationInfo

from hfc_design.controllers.controller import Controller, PerAxis
from hfc_design.controllers.rules import RuleBase
from hfc_design.core.numbers import Floats, Gains, Json, Memory, Own, Parameters, Plain
from hfc_design.core.overrides import flat
from hfc_design.core.plugins import GROUPS, Group
from hfc_design.core.records import NotNegative, Positive, Record, UserError

if TYPE_CHECKING:
    from plants import Machine  # which imports JAX

#: Largest command of each axis by its name, in the machine's order; None: no limit.
Limits = dict[str, float | None]


#: An error no larger than this counts as 0 [of the position]; 0: every error counts.
DeadZone = Annotated[NotNegative, Field(exclude_if=(0.0).__eq__)]


class later:
    """Name of a module that is imported only on access, because it starts JAX or draws.

    In the body of a class it is a method, or a value.
    """

    def __init__(self, module: str, name: str):
        self.module, self.name = module, name

    def __get__(self, record: Any, kind: Any = None) -> Any:
        attribute = getattr(importlib.import_module(self.module), self.name)
        bound = record is not None and isinstance(attribute, FunctionType)
        return attribute.__get__(record) if bound else attribute


class ControllerSettings(Record):
    """The ``[controller]`` of a scenario: start of a search, and the ranges that it may vary."""

    kind: str  # kind of the controller

    def fault(self, target: "Target") -> str | None:
        """Line that says why a search for ``target`` is impossible; it begins with the key."""
        return None

    @property
    def staged(self) -> bool:
        """Whether its genome has ``stages``, through which a distribution can be led."""
        return False


def controller_named(start: Plain, info: ValidationInfo) -> Plain:
    """Controller of the design named by ``start``; a record is returned as it is.

    Raises:
        ValueError: there is no such design, or it is not of the kind of the settings.
    """
    if not isinstance(start, str):
        return start
    try:
        design = (info.context or {})["named_design"](start)
    except UserError as error:
        raise ValueError(error.message) from None
    if (kind := design.controller.kind) != info.data.get("kind"):
        raise ValueError(f"is of kind {kind} and needs controller.kind = {kind!r}")
    return design.controller.model_dump()


class Target(NamedTuple):
    """Machine and conditions for which a controller is designed."""

    machine: "Machine"
    parameters: tuple[Parameters, ...]  # the record of each axis
    sample_time: float  # [s]
    limits: Limits
    bounds: Any = None  # settings of the search, which may bound what it varies
    follows_path: bool = True  # whether it does in every motion

    def of(self, k: int) -> "Target":
        """The target for axis ``k`` alone."""
        name, parameters = self.machine.axes[k], (self.parameters[k],)
        limits = {name: self.limits[name]}
        return self._replace(machine=self.machine.only(k), parameters=parameters, limits=limits)


class ReportContext(NamedTuple):
    """Facts about a design that a report needs besides its record."""

    machine: "Machine"
    parameters: tuple[Parameters, ...]  # the record of each axis
    #: What each axis told the control, signal -> (steps,); None where that is not known.
    signals: dict[str, dict[str, Floats]] | None
    #: Largest command that the controller of each axis keeps to; () for none.
    largest: tuple[float | None, ...] = ()

    def of(self, axis: str) -> "ReportContext":
        """The same for one axis."""
        k = self.machine.axes.index(axis)
        signals = None if self.signals is None else {axis: self.signals[axis]}
        machine, parameters, at = self.machine.only(k), (self.parameters[k],), slice(k, k + 1)
        return ReportContext(machine, parameters, signals, self.largest[at])

    @property
    def units(self) -> dict[str, str]:
        """Unit of each signal of the first axis."""
        return self.machine.drives[0].units


#: Of ``ControllerRecord.connecting``, where the error is all that a law reads.
CHANGES = (
    "The change of `error` is formed inside, from one sample to the next and without a filter: "
    "give the error as the encoder reads it."
)


def dead_zone_note(record: Own) -> list[str]:
    """Note on the dead zone of a record for ``ControllerRecord.connecting``; empty without one."""
    zone = record.dead_zone
    return [f"An `error` of up to {zone!r} either way counts as 0 inside."] if zone else []


def input_ranges(gains: dict[str, float], limit: float | None) -> dict[str, float]:
    """``ControllerRecord.input_range`` of signals with one gain each: (limit, or 1) / gain."""
    return {name: (limit or 1.0) / abs(gain) for name, gain in gains.items() if gain}


class Explain(NamedTuple):
    """Functions with which a kind explains its command at a sample; see ``runtime.explain``."""

    #: Signals that it reads at a sample, and those that it remembers of the one before.
    signals: Callable[[Own], tuple[list[str], list[str]]]
    #: (memory, readings of the sample before) -> memory.
    remember: Callable[[Memory, dict[str, float]], Memory]
    #: (record, parts) -> units with the rules that fire, and shares of the command.
    shown: Callable[[Own, Any], Json]
    #: Other names for what is remembered: as the change of a signal, say.
    changes: dict[str, str] = {}
    #: Names that inputs have in the program that a record comes from -> the signals that they are.
    names: Callable[[Own], dict[str, str]] = lambda record: {}


def errors_alone(record: Record) -> list[str]:
    """Signals of a law by default: the error and its rate."""
    return ["error", "error_rate"]


def nothing(record: Record) -> list[Any]:
    """Empty list, for features that a kind does not have."""
    return []


def numbers(record: Any, shown: "ReportContext") -> list[Any]:
    """Default section of a report on a controller: its numbers."""
    from hfc_design.core.tables import Table
    from hfc_design.plotting.section import Section  # which draw

    data: Json = record.model_dump(exclude={"kind", "sample_time_s"})
    values = {key.rpartition(".")[2]: value for key, value in flat(data).items()}
    rows = [[k, f"{x:.6g}"] for k, x in values.items() if isinstance(x, int | float)]
    listing = Table(f"Gains of the kind {record.kind}.", ["gain", "value"], rows)
    return [Section("The controller", "", listing, [])]


def names_of(part: type[Record]) -> tuple[str, ...]:
    """Names of a kind, from its record or settings; () if any name is allowed."""
    return get_args(part.model_fields["kind"].annotation)


class ControllerRecord(Record):
    """A kind of controller: a class whose objects are the controllers of design files.

    Its fields are the keys of a file. It has either ``law``, of one axis, or ``controller``, of a
    whole machine; other features that it lacks are None here, and the user who asks for them gets
    one sentence.
    """

    kind: str  # which kind of controller it is
    sample_time_s: Positive  # time from one command to the next [s]

    name: ClassVar[str] = ""  # of the kind, as its literal ``kind`` has it
    summary: ClassVar[str] = "your kind"  # for hfc list controllers
    record: ClassVar[Any]  # itself
    settings: ClassVar[type[ControllerSettings] | None] = None  # in a scenario; None: not searched
    #: What a search can do with it: (settings, target) -> Genome.
    genome: ClassVar[Any] = None
    #: law(limit) -> AxisLaw; limit is the largest command.
    law: ClassVar[Any] = None
    #: controller(limits) -> Controller, of a machine whose axes have these largest commands.
    controller: ClassVar[Any] = None
    path: ClassVar[bool] = False  # whether it has to see the path of an X-Y machine
    #: axis_records() -> the record of each axis, where they differ; formats write them one by one.
    axis_records: ClassVar[Any] = None
    #: units_that_matter(gains) -> (n,) how many units of its hierarchy do, of a population.
    units_that_matter: ClassVar[Any] = None
    #: reads() -> signals that its law reads at a sample, an argument of the C code each; None: any.
    reads: ClassVar[Any] = errors_alone
    #: widths() -> differences that have to be more than 0 in single precision.
    widths: ClassVar[Any] = nothing
    #: What a report shows: sections(shown) -> sections.
    sections: ClassVar[Any] = numbers
    #: adapted(memory) -> the record with what its law's memory has made of it, None where nothing.
    adapted: ClassVar[Any] = None
    #: learnt(axes, memory) -> the same of what commands a whole machine.
    learnt: ClassVar[Any] = None
    #: of_gains(gains by name) -> a record's keys.
    of_gains: ClassVar[Any] = None
    rule_base: ClassVar[RuleBase | None] = None
    no_rules: ClassVar[str] = "no rule tables; use c or st"  # why, for who asks for a file of them
    #: lookup(points) -> terms tabulated for a processor without exp: "law", the law of the runtime
    #: with them (limit -> AxisLaw), and its largest deviation.
    lookup: ClassVar[Any] = None
    explain: ClassVar[Explain | None] = None
    #: table_gains() -> gains of the rule table, which a stable range bounds: name -> (K_1, K_2).
    table_gains: ClassVar[Any] = None
    #: What ``hfc plot`` draws: pictures(drive) -> for each available picture ("surface", "terms",
    #: "tables", "tree") a function: name of a unit -> ``pictures.section.Drawn``. Without a name it
    #: draws the last unit.
    pictures: ClassVar[Any] = None

    @classmethod
    def __pydantic_init_subclass__(cls, **others: Any) -> None:
        """Set the record and the name of the kind."""
        cls.record = cls
        if names := names_of(cls):
            cls.name = names[0]

    def law_gains(self) -> Gains:
        """Numbers of its law, for one individual; in a population, arrays with a trailing axis."""
        raise NotImplementedError

    def inside(self, axes: tuple[str, ...]) -> "dict[str, ControllerRecord]":
        """Controllers that this one wraps, on a machine with these axes.

        The keys are the names of the axes, or "" for a controller of all of them.
        """
        return {}

    def without_adaptation(self) -> Self:
        """The record without its adaptation."""
        return self

    def structure(self) -> str:
        """Structure as ``Genome.notation`` writes it; "": its kind has only one."""
        return ""

    def input_range(self, limit: float | None) -> dict[str, float]:
        """Range of each signal of an axis: to its end, or to where it alone commands the limit.

        "error_change" is the change of the error in a sample. Signals that are not named go to 1.
        Test vectors go a little beyond.
        """
        return {}

    def connecting(self) -> list[str]:
        """Facts that whoever connects its signals needs beside their meanings, a line each."""
        return []

    def controller_of(self, limits: Limits) -> Controller:
        """Controller of a machine whose axes have these limits of their commands."""
        if self.controller is not None:
            controller: Controller = self.controller(limits)
            return controller
        return PerAxis(self.kind, tuple(map(self.law, limits.values())))

    @classmethod
    def renewed(cls, data: Json, keys: list[str]) -> None:
        """Remove from a record's ``data`` the values that are derived from these dotted keys.

        Raises:
            ValueError: a key changes nothing; the line begins with it.
        """


def kinds() -> Group[Any]:
    """Every kind by its name, from ``kinds.KINDS``."""
    return GROUPS["controller"]


def require(capability: Any, design: Any, lacks: str) -> Any:
    """Return the capability of a kind.

    Raises:
        UserError: the kind does not have it; the line names the design and what it ``lacks``.
    """
    if capability is None:
        raise UserError(f"design {design.name} is of kind {design.controller.kind}: {lacks}")
    return capability
