"""Base class of all kinds of controller, with everything that the rest of the package calls.

Each kind has a folder beside this file; ``KIND`` in the folder's ``__init__`` registers the kind
(``KINDS``: several ones). Never imports JAX.
"""

import importlib
import sys
from collections import deque
from collections.abc import Callable, Iterator
from importlib.util import resolve_name
from types import FunctionType
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, NamedTuple, Self, get_args

from pydantic import Field, ValidationInfo

from hfc_design.controllers.controller import Controller, PerAxis
from hfc_design.controllers.rules import RuleBase
from hfc_design.core.numbers import SCALARS, Floats, Gains, Json, Memory, Own, Parameters, Plain
from hfc_design.core.overrides import flat
from hfc_design.core.plugins import GROUPS, Group
from hfc_design.core.records import NotNegative, Positive, Record, UserError
from hfc_design.core.tables import Table

if TYPE_CHECKING:
    from plants import Machine  # which imports JAX

#: Largest command of each axis by its name, in the machine's order; None: no limit.
Limits = dict[str, float | None]


#: An error no larger than this counts as 0 [of the position]; 0: every error counts.
DeadZone = Annotated[NotNegative, Field(exclude_if=(0.0).__eq__)]


class later:
    """Class attribute that is imported on use, because its module may load JAX or matplotlib.

    A module whose name begins with a dot is in the package of the class. A function of the module
    becomes a method of the class; any other object is used as it is.
    """

    def __init__(self, module: str, name: str):
        self.module, self.name = module, name

    def __set_name__(self, kind: type, attribute: str) -> None:
        if self.module.startswith("."):
            self.module = resolve_name(self.module, sys.modules[kind.__module__].__package__)

    def __get__(self, record: Any, kind: Any = None) -> Any:
        attribute = getattr(importlib.import_module(self.module), self.name)
        bound = record is not None and isinstance(attribute, FunctionType)
        return attribute.__get__(record) if bound else attribute


class ControllerSettings(Record):
    """Table ``[controller]`` of a scenario: the start of a search, and what the search may vary."""

    kind: str  # kind of the controller

    def fault(self, target: "Target") -> str | None:
        """Return None, or why a search for ``target`` is impossible; the line begins with a key."""
        return None

    @property
    def staged(self) -> bool:
        """True if strategies that move a distribution (cma) can search it in ``Genome.stages``."""
        return False


def controller_named(start: Plain, info: ValidationInfo) -> Plain:
    """Return the controller of the design that ``start`` names, as a dict; a record unchanged.

    Raises:
        ValueError: there is no such design, or its kind is not that of the settings.
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


def sampled_otherwise(start: "ControllerRecord | None", target: "Target") -> str | None:
    """Return a message on a start with another sample time than that of ``target``, or None."""
    if start is None or start.sample_time_s == target.sample_time:
        return None
    needed = f"simulation.sample_time_s = {target.sample_time} (got {start.sample_time_s})"
    return f"controller.start: must have the sample time {needed}"


class Target(NamedTuple):
    """Machine and conditions for which a controller is designed."""

    machine: "Machine"
    parameters: tuple[Parameters, ...]  # physical parameters of each axis
    sample_time: float  # [s]
    limits: Limits
    bounds: Any = None  # settings of the strategy, which may bound the searched numbers
    follows_path: bool = True  # True if the machine follows a path in every motion
    modes: tuple[float, ...] = ()  # known modes that its model lacks [Hz]

    def of(self, k: int) -> "Target":
        """Return the target for axis number ``k`` alone."""
        name, parameters = self.machine.axes[k], (self.parameters[k],)
        limits = {name: self.limits[name]}
        return self._replace(machine=self.machine.only(k), parameters=parameters, limits=limits)


class ReportContext(NamedTuple):
    """Facts about a design that a report needs besides its record."""

    machine: "Machine"
    parameters: tuple[Parameters, ...]  # physical parameters of each axis
    #: Axis -> signal -> its values (steps,) in the motion; None: not known.
    signals: dict[str, dict[str, Floats]] | None
    #: Limit of the command of each axis that the design has, None: no limit; (): not known.
    largest: tuple[float | None, ...] = ()

    def of(self, axis: str) -> "ReportContext":
        """Return the facts for one axis alone."""
        k = self.machine.axes.index(axis)
        signals = None if self.signals is None else {axis: self.signals[axis]}
        machine, parameters, at = self.machine.only(k), (self.parameters[k],), slice(k, k + 1)
        return ReportContext(machine, parameters, signals, self.largest[at])

    def called(self, axis: str) -> str:
        """Return the name of an axis in texts."""
        return axis.upper() if len(self.machine.axes) > 1 else "the axis"

    @property
    def units(self) -> dict[str, str]:
        """Unit of each signal of the first axis."""
        return self.machine.drives[0].units


def memories(
    record: Own, signals: dict[str, Floats], limit: float | None = None
) -> Iterator[Memory]:
    """Yield the memory of a record's law before each sample of a motion, and the last one.

    The law reads the ``signals`` of an axis in the motion, which takes about 0.1 ms a sample.
    """
    law, gains, names = record.law(limit), record.law_gains(), record.reads()
    memory = law.begun(SCALARS, 0.0, gains)
    yield memory
    for values in zip(*(signals[name].tolist() for name in names), strict=True):
        _, memory = law.step(SCALARS, gains, memory, dict(zip(names, values, strict=True)))
        yield memory


def last_memory(record: Own, signals: dict[str, Floats], limit: float | None = None) -> Memory:
    """Return the last one of ``memories``."""
    return deque(memories(record, signals, limit), maxlen=1).pop()


#: Note for ``ControllerRecord.connecting`` of a law that reads only the error.
CHANGES = (
    "The change of `error` is formed inside, from one sample to the next and without a filter: "
    "give the error as the encoder reads it."
)


def dead_zone_note(record: Own) -> list[str]:
    """Return a note on a record's dead zone for ``ControllerRecord.connecting``; [] if it is 0."""
    zone = record.dead_zone
    return [f"An `error` of up to {zone!r} either way counts as 0 inside."] if zone else []


def input_ranges(gains: dict[str, float], limit: float | None) -> dict[str, float]:
    """Return a ``ControllerRecord.input_range`` from gains of signals: (limit, or 1) / |gain|."""
    return {name: (limit or 1.0) / abs(gain) for name, gain in gains.items() if gain}


class Explain(NamedTuple):
    """Functions with which a kind explains its command in a sample; see ``runtime.explain``."""

    #: record -> (names of signals of the sample, names of signals of the previous sample).
    signals: Callable[[Own], tuple[list[str], list[str]]]
    #: (memory, signals of the previous sample) -> memory with these signals as the previous ones.
    remember: Callable[[Memory, dict[str, float]], Memory]
    #: (record, parts) -> fuzzy units with the rules that fire, and the parts of the command.
    shown: Callable[[Own, Any], Json]
    #: Name of the change of a signal -> name of the previous signal that it can replace.
    changes: dict[str, str] = {}
    #: record -> {name of an input in the program that the record was imported from: its signal}.
    names: Callable[[Own], dict[str, str]] = lambda record: {}


def errors_alone(record: Record) -> list[str]:
    """Return the signals that a law reads by default: the error and its rate."""
    return ["error", "error_rate"]


def nothing(record: Record) -> list[Any]:
    """Return an empty list, for features that a kind does not have."""
    return []


def numbers(record: Any, shown: "ReportContext") -> list[Any]:
    """Return the default section of a report on a controller: a table of its numbers."""
    from hfc_design.plotting.section import Section  # which loads matplotlib

    data: Json = record.model_dump(exclude={"kind", "sample_time_s"})
    values = {key.rpartition(".")[2]: value for key, value in flat(data).items()}
    rows = [[k, f"{x:.6g}"] for k, x in values.items() if isinstance(x, int | float)]
    listing = Table(f"Gains of the kind {record.kind}.", ["gain", "value"], rows)
    return [Section("The controller", "", listing, [])]


def names_of(part: type[Record]) -> tuple[str, ...]:
    """Return the allowed values of the field ``kind`` of a record or settings; (): any name."""
    return get_args(part.model_fields["kind"].annotation)


class ControllerRecord(Record):
    """A kind of controller: a class whose objects are the controllers of design files.

    Its fields are the keys of a file. It has either ``law``, for one axis, or ``controller``, for a
    whole machine. Other features may be None: the kind does not have them, and a user who asks for
    one gets a message.
    """

    kind: str  # which kind of controller it is
    sample_time_s: Positive  # time from one command to the next [s]

    name: ClassVar[str] = ""  # of the kind: the first allowed value of the field ``kind``
    summary: ClassVar[str] = "your kind"  # for hfc list controllers
    record: ClassVar[Any]  # the class itself
    settings: ClassVar[type[ControllerSettings] | None] = None  # in a scenario; None: not searched
    #: genome(settings, target) -> Genome, the operations of a search on this kind.
    genome: ClassVar[Any] = None
    #: law(limit) -> AxisLaw; limit is the largest command.
    law: ClassVar[Any] = None
    #: controller(limits) -> Controller of a machine whose axes have these largest commands.
    controller: ClassVar[Any] = None
    path: ClassVar[bool] = False  # True if the controller reads the path of an X-Y machine
    #: axis_records() -> {axis: its record}, for a kind with a separate controller for each axis.
    axis_records: ClassVar[Any] = None
    #: units_that_matter(gains) -> (n,) number of fuzzy units that matter in each individual.
    units_that_matter: ClassVar[Any] = None
    #: reads() -> signals that the law reads in a sample; if ``reads`` itself is None, it reads any.
    reads: ClassVar[Any] = errors_alone
    #: widths() -> widths of the terms in single precision; C code in float cannot divide by 0.
    widths: ClassVar[Any] = nothing
    #: sections(shown) -> the sections of a report on the controller.
    sections: ClassVar[Any] = numbers
    #: adapted(memory) -> the record with what the law has learned in its memory; None: nothing.
    adapted: ClassVar[Any] = None
    #: learnt(axes, memory) -> the same as ``adapted`` for a controller of a whole machine.
    learnt: ClassVar[Any] = None
    #: of_gains(gains by name) -> keys of the controller with these gains in a design file.
    of_gains: ClassVar[Any] = None
    rule_base: ClassVar[RuleBase | None] = None
    #: Keys of ``adaptation`` that are 0 in a design that does not adapt; (): the kind has none.
    steps_of_adaptation: ClassVar[tuple[str, ...]] = ()
    no_rules: ClassVar[str] = "no rule tables; use c or st"  # message on formats with rule tables
    #: lookup(points) -> dict for code that has a table of ``points`` values in place of exp: "law"
    #: (limit -> AxisLaw with the table), "deviation" (largest error found) and others.
    lookup: ClassVar[Any] = None
    explain: ClassVar[Explain | None] = None
    #: table_gains() -> {name: (K_1, K_2)}, gains of the rule table, for a check of stability.
    table_gains: ClassVar[Any] = None
    #: Pictures for ``hfc plot``: pictures(drive) -> {name of a picture such as "surface", "terms",
    #: "tables" or "tree": {name of a unit: ``plotting.section.Drawn``}}. If a user names no unit,
    #: the last one is drawn.
    pictures: ClassVar[Any] = None

    @classmethod
    def __pydantic_init_subclass__(cls, **others: Any) -> None:
        """Set the record and the name of the kind."""
        cls.record = cls
        if names := names_of(cls):
            cls.name = names[0]

    def law_gains(self) -> Gains:
        """Return the gains of the law with the numbers of this record (one individual)."""
        raise NotImplementedError

    def inside(self, axes: tuple[str, ...]) -> "dict[str, ControllerRecord]":
        """Return the inner controllers of this one on a machine with these axes, by axis.

        The key is "" for an inner controller of all axes.
        """
        return {}

    def without_adaptation(self) -> Self:
        """Return a record whose controller does not adapt; what it has learned remains."""
        if not self.steps_of_adaptation:
            return self
        adaptation, still = dict(self)["adaptation"], dict.fromkeys(self.steps_of_adaptation, 0.0)
        return self.model_copy(update={"adaptation": adaptation.model_copy(update=still)})

    def structure(self) -> str:
        """Return the structure as ``Genome.notation`` writes it; "" if the kind has only one."""
        return ""

    def input_range(self, limit: float | None) -> dict[str, float]:
        """Return the largest magnitude of each signal of an axis in test vectors, roughly.

        It is the end of the signal's terms, or the value that alone commands ``limit`` (None: 1).
        "error_change" is the change of the error in a sample. Signals without an entry go to 1.
        """
        return {}

    def connecting(self) -> list[str]:
        """Return notes for the person who connects signals to exported code, a line each."""
        return []

    def controller_of(self, limits: Limits) -> Controller:
        """Return the controller for a machine whose axes have these limits of the command."""
        if self.controller is not None:
            controller: Controller = self.controller(limits)
            return controller
        return PerAxis(self.kind, tuple(map(self.law, limits.values())))

    @classmethod
    def renewed(cls, data: Json, keys: list[str]) -> None:
        """Remove from a record's ``data`` the values that are derived from the changed ``keys``.

        Raises:
            ValueError: a change of one of these dotted keys has no effect; the line begins with it.
        """


def kinds() -> Group[Any]:
    """Return all kinds by name: ``kinds.KINDS``, which this file cannot import."""
    return GROUPS["controller"]


def require(capability: Any, design: Any, lacks: str) -> Any:
    """Return ``capability``, a feature of the kind of ``design``.

    Raises:
        UserError: it is None; the line names the design and ends with the reason ``lacks``.
    """
    if capability is None:
        raise UserError(f"design {design.name} is of kind {design.controller.kind}: {lacks}")
    return capability
