"""What a kind of controller is: one record of everything that the rest of the package asks it.

A kind is a folder beside this file; ``KIND`` in its ``__init__`` makes it known, ``KINDS`` several.
What a kind lacks is None here, and one sentence to the user. Never imports JAX.
"""

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

from pydantic import Field, ValidationInfo

from hfc_design.controllers.controller import AxisLaw, Controller, PerAxis
from hfc_design.controllers.rules import RuleBase
from hfc_design.core.dotted import flat
from hfc_design.core.numbers import Floats, Gains, Integers, Json, Memory, Own, Parameters, Plain
from hfc_design.core.plugins import Group
from hfc_design.core.records import NotNegative, Positive, Record, UserError

if TYPE_CHECKING:
    from plants import Machine  # which imports JAX

#: Largest command of each axis by its name, in the machine's order; None: no limit.
Limits = dict[str, float | None]


#: An error no larger than this counts as 0 [of the position]; 0: every error counts.
DeadZone = Annotated[NotNegative, Field(exclude_if=(0.0).__eq__)]


class ControllerRecord(Record):
    """A controller in a design file; each kind adds keys of its own."""

    kind: str  # which kind of controller it is
    sample_time_s: Positive  # time from one command to the next [s]

    @classmethod
    def renewed(cls, data: Json, keys: list[str]) -> None:
        """Take out of a record's ``data`` what follows from its values of these dotted keys.

        Raises:
            ValueError: a key changes nothing; the line begins with it.
        """


class ControllerSettings(Record):
    """The ``[controller]`` of a scenario: what a search starts from and may vary."""

    kind: str  # which kind of controller is looked for

    def fault(self, target: "Target") -> str | None:
        """What makes a search for ``target`` impossible, in a line that begins with the key."""
        return None

    @property
    def staged(self) -> bool:
        """Whether its genome has ``stages``, through which a distribution can be led."""
        return False


def controller_named(start: Plain, info: ValidationInfo) -> Plain:
    """The controller of the design that ``start`` names; a record stays one.

    Raises:
        ValueError: there is no such design, or it is not of the kind of the settings.
    """
    if not isinstance(start, str):
        return start
    try:
        design = (info.context or {})["named_design"](start)
    except UserError as error:
        raise ValueError(error.typed) from None
    if (kind := design.controller.kind) != info.data.get("kind"):
        raise ValueError(f"is of kind {kind}, which needs controller.kind = {kind!r}")
    return design.controller.model_dump()


class Target(NamedTuple):
    """What a controller is designed for."""

    machine: "Machine"
    parameters: tuple[Parameters, ...]  # the record of each axis
    sample_time: float  # [s]
    limits: Limits
    bounds: Any = None  # settings of the search, which may bound what it varies
    follows_path: bool = True  # whether it does in every motion

    def of(self, k: int) -> "Target":
        """The same for axis ``k`` alone."""
        name, own = self.machine.axes[k], (self.parameters[k],)
        limits = {name: self.limits[name]}
        return self._replace(machine=self.machine.only(k), parameters=own, limits=limits)


class Inside(NamedTuple):
    """The controllers that a controller of a whole machine is made around."""

    #: (record, axes) -> the record of each axis by its name, or "" and that of all of them.
    records: Callable[[Own, tuple[str, ...]], dict[str, Own]]
    replaced: Callable[[Own, dict[str, Own]], Own]  # (record, such records) -> record


class Shown(NamedTuple):
    """What a report knows of a design besides its record."""

    machine: "Machine"
    parameters: tuple[Parameters, ...]  # the record of each axis
    #: What each axis told the control, signal -> (steps,); None where that is not known.
    signals: dict[str, dict[str, Floats]] | None
    #: Largest command that the controller of each axis keeps to; () for none.
    largest: tuple[float | None, ...] = ()

    def of(self, axis: str) -> "Shown":
        """The same of one axis."""
        k = self.machine.axes.index(axis)
        own = None if self.signals is None else {axis: self.signals[axis]}
        machine, parameters, at = self.machine.only(k), (self.parameters[k],), slice(k, k + 1)
        return Shown(machine, parameters, own, self.largest[at])

    @property
    def units(self) -> dict[str, str]:
        """Unit of each signal of the first axis."""
        return self.machine.drives[0].units


#: Of ``Kind.connecting``, where the error is all that a law reads.
CHANGES = (
    "The change of `error` is formed inside, from one sample to the next and without a filter: "
    "give the error as the encoder reads it."
)


def zone_told(record: Own) -> list[str]:
    """The dead zone of a record for ``Kind.connecting``; nothing without one."""
    zone = record.dead_zone
    return [f"An `error` of up to {zone!r} either way counts as 0 inside."] if zone else []


def reach_of(gains: dict[str, float], limit: float | None) -> dict[str, float]:
    """``Kind.reach`` of signals that have a gain each: where each commands the limit, or 1."""
    return {name: (limit or 1.0) / abs(gain) for name, gain in gains.items() if gain}


def numbers(record: ControllerRecord, shown: Shown) -> list[Any]:
    """The section of a report on a controller that says nothing else of itself."""
    from hfc_design.pictures.section import Listing, Section  # which draw

    own: Json = record.model_dump(exclude={"kind", "sample_time_s"})
    found = {key.rpartition(".")[2]: value for key, value in flat(own).items()}
    rows = [[k, f"{x:.6g}"] for k, x in found.items() if isinstance(x, int | float)]
    listing = Listing(f"Gains of the kind {record.kind}.", ["gain", "value"], rows)
    return [Section("The controller", "", listing, [])]


class Explain(NamedTuple):
    """How a kind explains what it does at a sample; see ``runtime.explain``."""

    #: Signals that it reads at a sample, and those that it remembers of the one before.
    signals: Callable[[Own], tuple[list[str], list[str]]]
    #: (memory, readings of the sample before) -> memory.
    remember: Callable[[Memory, dict[str, float]], Memory]
    #: (record, parts) -> units with the rules that fire, and shares of the command.
    shown: Callable[[Own, Any], Json]
    #: The record without its adaptation.
    held: Callable[[Own], Own] = lambda record: record
    #: Other names for what is remembered: as the change of a signal, say.
    changes: dict[str, str] = {}
    #: Names that inputs have in the program that a record comes from -> the signals that they are.
    names: Callable[[Own], dict[str, str]] = lambda record: {}


@dataclass(frozen=True, eq=False)
class Kind:
    """A kind of controller."""

    name: str
    summary: str  # for hfc list controllers
    record: type[ControllerRecord]  # in a design file
    settings: type[ControllerSettings] | None  # in a scenario; None: nothing searches it
    #: The numbers of a record, for one individual; arrays with a trailing axis in a population.
    gains: Callable[[Own], Gains]
    #: The law of one axis: of (record, limit of the command).
    law: Callable[[Own, float | None], AxisLaw] | None = None
    #: The controller of a whole machine, of (record, limits), where it is no law for each axis.
    controller: Callable[[Own, Limits], Controller] | None = None
    inside: Inside | None = None
    #: Whether it has to see the path of an X-Y machine.
    path: bool = False
    #: The record of each axis by its name, where they differ; formats write them one by one.
    axes: Callable[[Own], dict[str, Own]] | None = None
    #: What a search can do with it: (settings, target) -> Genome.
    genome: Callable[[Own, Target], Any] | None = None
    #: The structure of a record as ``Genome.notation`` tells it; "": its kind has but one.
    structure: Callable[[Own], str] = lambda record: ""
    #: How many units of its hierarchy matter: (record of one, gains of a population) -> (n,).
    units: Callable[[Own, Gains], Integers] | None = None
    #: Signals that its law reads at a sample, an argument of the C code each; None: any.
    reads: Callable[[Own], list[str]] | None = lambda record: ["error", "error_rate"]
    #: The record with what the memory of its law has made of it; None where that is nothing.
    adapted: Callable[[Own, Memory], Own | None] | None = None
    #: The same of what commands a whole machine: of (record, names of the axes, memory).
    learnt: Callable[[Own, tuple[str, ...], Memory], Own | None] | None = None
    #: A record of given gains by their names.
    of_gains: Callable[[dict[str, float]], Json] | None = None
    #: How far the signals go of one axis until its range ends, or until each alone commands about
    #: the limit: (record, limit) -> sizes; "error_change" is of the error in a sample. Those that
    #: are not named go to 1. Test vectors go a little beyond.
    reach: Callable[[Own, float | None], dict[str, float]] = lambda record, limit: {}
    #: What whoever connects its signals has to know beside what they are, a line each.
    connecting: Callable[[Own], list[str]] = lambda record: []
    rules: RuleBase | None = None
    no_rules: str = "no rule tables"  # why there are no ``rules``, for who asks for a file of them
    #: Differences that have to be more than 0 in single precision.
    widths: Callable[[Own], list[float]] = lambda record: []
    #: Terms tabulated for a machine without exp: (record, points) -> "law", that of the runtime
    #: with them: limit -> AxisLaw, and how far it is off.
    lookup: Callable[[Own, int], Json] | None = None
    explain: Explain | None = None
    #: Gains of the rule table, which a stable range bounds: record -> {name: (K_1, K_2)}.
    table_gains: Callable[[Own], dict[str, tuple[float, float]]] | None = None
    #: What ``hfc plot`` draws: (record, drive) -> "surface", "terms", "tables", "tree", as far as
    #: there are, -> name of a unit -> ``pictures.section.Drawn``; the last one where none is named.
    pictures: Callable[[Own, Any], dict[str, dict[str, Any]]] | None = None
    #: What a report shows: (record, Shown) -> sections.
    sections: Callable[[Own, Shown], list[Any]] = numbers

    def __repr__(self) -> str:
        return f"Kind({self.name!r})"

    def controller_of(self, record: Own, limits: Limits) -> Controller:
        """The controller of a machine whose axes have these limits of their commands."""
        if self.controller is not None:
            return self.controller(record, limits)
        assert self.law is not None  # see fault
        return PerAxis(self.name, tuple(self.law(record, limit) for limit in limits.values()))


def kinds() -> Group[Any]:
    """Every kind by its name."""
    from hfc_design.controllers.kinds import KINDS  # which finds all that import this

    return KINDS


def later(module: str, name: str) -> Callable[..., Any]:
    """A function of a module that is imported at the first call: it starts JAX, or draws."""

    def call(*arguments: Any) -> Any:
        return getattr(importlib.import_module(module), name)(*arguments)

    return call


def needed(capability: Any, design: Any, lacks: str) -> Any:
    """The capability of a kind.

    Raises:
        UserError: the kind has none; the line names the design and what it ``lacks``.
    """
    if capability is None:
        raise UserError(f"design {design.name} is of kind {design.controller.kind}: {lacks}")
    return capability
