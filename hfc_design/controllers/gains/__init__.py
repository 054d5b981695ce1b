"""Kinds whose parameters are a few gains: pd, pid, and every law of a user.

The folder is not a kind itself; ``kind_of`` makes a kind from a law. Never imports JAX.
"""

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any, ClassVar, NamedTuple, TypeAlias

from pydantic import Field, create_model, model_validator

from hfc_design.controllers.controller import AxisLaw, Signals
from hfc_design.controllers.kind import ControllerRecord, ControllerSettings, Target, later
from hfc_design.core.numbers import Constant, Gains, Memory, Own, Scalar, Xp
from hfc_design.core.records import Finite, Label, Record, UserError, checked, ordered
from hfc_design.core.wording import one_of

Range = tuple[float, float]
#: Type of a NamedTuple with a ``Range`` for each gain.
Ranges: TypeAlias = Any


class Law(NamedTuple):
    """Control law as pure functions of scalars, and the search ranges of its gains::

        memory = law.initial_memory(0.0)
        command, memory = law.step(sample_time, gains, memory, signals)

    ``ranges`` is a NamedTuple of (low, high); ``gains`` is of the same class, with numbers. A range
    above zero is searched on a logarithmic scale, any other range on a linear one. ``signals`` has
    ``error``, ``error_rate``, the signals of the reference and the plant's readings.
    """

    name: str  # the ``kind`` of a controller in a file
    ranges: Ranges
    initial_memory: Callable[[Scalar], Memory]
    step: Callable[[float, Gains, Memory, Signals], tuple[Scalar, Memory]]


#: Plants of the package with errors in encoder steps, millimetres or degrees: ranges of gains for
#: one of these plants are a first guess for the other ones, but not for plants in other units.
FIVE_AXES = ("five-axis", "five-axis-b", "five-axis-coupled")
FEEDS = ("feed-drive", "milling-table", "positioning-stage", *FIVE_AXES)
genome_of_gains = later("hfc_design.controllers.gains.genome", "GainsGenome")
"""Genome of a kind with settings of ``settings_of`` and with ``of_gains``."""


class GainsSettings(ControllerSettings):
    """Settings of a search for a controller with a few gains, each in a range."""

    own_ranges: ClassVar[Ranges]  # default ranges of the kind
    own_plants: ClassVar[tuple[str, ...]] = ()  # plants that they are for, by name; (): any
    #: search ranges [low, high] of gains, where they differ from those of the kind [of the gain];
    #: for a plant of your own, all gains need a range, because those of the kind do not suit it
    ranges: dict[Label, Annotated[tuple[Finite, Finite], ordered]] = {}

    @model_validator(mode="after")
    def _fit(self) -> "GainsSettings":
        names = self.own_ranges._fields
        for name in self.ranges:
            if name not in names:
                raise ValueError(f"ranges.{name}: unknown; {one_of(name, names)}")
        return self

    def fault(self, target: Target) -> str | None:
        """Return a line on ranges that are missing, because the defaults do not suit; or None."""
        units = target.machine.drives[0].units
        counted = f"(errors in {units['error']}, commands in {units['command']})"
        message = self.lacking(target.machine.name, counted)
        return message and f"controller.ranges: {message}"

    def lacking(self, plant: str, counted: str) -> str | None:
        """Return a text on gains without a range for ``plant`` (units: ``counted``), or None."""
        missing = [name for name in self.own_ranges._fields if name not in self.ranges]
        if not missing or not self.own_plants or plant in self.own_plants:
            return None
        known = f"the ranges of {self.kind!r} are for {', '.join(self.own_plants)}"
        return (
            f"{', '.join(missing)}: no range for {plant} {counted}; {known}; give each a "
            "[low, high] in controller.ranges, or use kind = 'pid+ff', which derives its ranges"
        )

    @property
    def staged(self) -> bool:
        """True: a strategy that moves a distribution can search all gains in one stage."""
        return True

    def searched(self) -> Ranges:
        """Return the search ranges: those of the kind, changed by the user's ``ranges``."""
        return self.own_ranges._replace(**self.ranges)


def settings_of(ranges: Ranges, plants: tuple[str, ...] = ()) -> type[GainsSettings]:
    """Return the class of the settings of a kind whose gains have ``ranges``, a NamedTuple.

    ``plants`` are the names of the plants that the ranges are for; () means any plant.
    """

    class Settings(GainsSettings):
        own_ranges = ranges
        own_plants = plants

    return Settings


def kind_of_gains(
    name: str,
    ranges: Ranges,
    sample: Callable[..., tuple[Scalar, Memory, None]],
    start: Callable[[AxisLaw, Scalar], Memory],
    key: str = "",
    structure: Callable[[Own], Any] = lambda record: None,
    tells: bool = False,
    prime: Callable[..., Memory] | None = None,
    base: type[ControllerRecord] = ControllerRecord,
    plants: tuple[str, ...] = (),
    **further: Any,
) -> type[ControllerRecord]:
    """Return a kind whose gains have ``ranges``; in a design file they are under ``key`` or name.

    ``sample``, ``start``, ``tells`` and ``prime`` are those of ``AxisLaw``, ``structure`` computes
    its ``structure`` from a record. ``base`` has the fields of a design besides the gains.
    ``plants`` as in ``settings_of``; ``further`` are other attributes of a ``ControllerRecord``.
    """
    if unknown := [x for x in further if not hasattr(ControllerRecord, x)]:
        raise TypeError(f"a controller has no {', '.join(unknown)}")
    key = key or name
    numbers: Any = dict.fromkeys(ranges._fields, (Finite, ...))
    field = Field(description="its gains, by name")
    gains: Any = {key: (create_model("Gains", __base__=Record, **numbers), field)}
    abilities: dict[str, Any] = {
        "name": name,
        "settings": settings_of(ranges, plants),
        "genome": genome_of_gains,
        "law_gains": lambda record: type(ranges)(**dict(getattr(record, key))),
        "law": lambda record, limit: AxisLaw(
            sample, start, record.sample_time_s, limit, structure(record), tells, prime
        ),
        "of_gains": staticmethod(lambda gains: {key: gains}),
        **further,
    }
    made = create_model("Design", __base__=base, **gains)
    for ability, value in abilities.items():
        setattr(made, ability, value)
    return made


def kind_of(law: Law) -> type[ControllerRecord]:
    """Return a kind with the ``law`` of a user; UserError if its ranges are wrong."""
    source = f"controller {law.name!r}"
    if not getattr(law.ranges, "_fields", ()):
        raise UserError(f"{source}: ranges must be a NamedTuple with a (low, high) for each gain")
    checked(settings_of(law.ranges), {"kind": "", "ranges": law.ranges._asdict()}, source, Path())

    code, reads = law._replace(ranges=()), _asked_for(law)
    options: Any = {
        "key": "gains",
        # A user's law may need the value of the sample time, so it is a constant of the code.
        "structure": lambda record: (code, Constant(record.sample_time_s)),
        "summary": "your law",
        "reads": lambda record: reads,
    }
    return kind_of_gains(law.name, law.ranges, _sample, _start, **options)


class _Asked(dict[str, float]):
    """Signals that are created with the value 1 when a law reads them."""

    def __missing__(self, name: str) -> float:
        return self.setdefault(name, 1.0)

    def get(self, name: str, default: Any = None) -> Any:
        return self[name]


def _asked_for(law: Law) -> list[str]:
    """Return the names of the signals that a ``law`` reads in a step; it always reads the same."""
    signals, middle = _Asked(), (0.5 * (low + high) for low, high in law.ranges)
    with suppress(Exception):  # the simulator will report the error and its place
        law.step(0.01, type(law.ranges)(*middle), law.initial_memory(0.0), signals)
    return list(signals) or ["error", "error_rate"]


def _sample(
    xp: Xp, law: AxisLaw, gains: Gains, memory: Memory, signals: Signals
) -> tuple[Scalar, Memory, None]:
    user_law, sample_time = law.structure
    return *user_law.step(sample_time, gains, memory, signals), None


def _start(law: AxisLaw, zero: Scalar) -> Memory:
    return law.structure[0].initial_memory(zero)
