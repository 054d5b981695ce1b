"""Records of linear controllers in design files and scenarios. Never imports JAX."""

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from operator import not_
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, Field, model_validator

from hfc_design.controllers.controller import FOLLOWED, AxisLaw
from hfc_design.controllers.kind import (
    ControllerRecord,
    ControllerSettings,
    Target,
    input_ranges,
    later,
)
from hfc_design.controllers.linear.law import (
    AHEAD,
    ERRORS,
    LinearGains,
    Structure,
    initial_memory,
    sample,
    section,
)
from hfc_design.core.numbers import Floats, Json
from hfc_design.core.records import Finite, Label, NotNegative, Positive, Record, ordered
from hfc_design.core.wording import one_of

#: Feed-forward gains, each searched as a multiple of the nominal drive's need.
MULTIPLES = ("velocity", "acceleration", "coulomb", "load")
#: Names of the multiples among the searched numbers.
FORWARD = tuple(f"{name}_multiple" for name in MULTIPLES)
Pair = Annotated[tuple[Finite, Finite], ordered]
Range = Annotated[tuple[Positive, Positive], ordered]
#: Suffix that makes a resonator's name the name of its command's lead, a searched number.
LEAD = "_lead"
#: Largest number of frequencies with a resonator.
MOST_FREQUENCIES = 8
#: Smallest distance of two frequencies, in shares of the higher one: closer ones would need
#: extreme gains.
APART = 1e-3


def rising(frequencies: tuple[float, ...]) -> tuple[float, ...]:
    """Return ``frequencies``; ValueError if they do not rise by at least 0.1 % each."""
    for low, high in pairwise(frequencies):
        if not low < (1.0 - APART) * high:
            raise ValueError("frequencies must rise, each by at least 0.1 %")
    return frequencies


#: Rising frequencies [rad/s].
Frequencies = Annotated[
    tuple[Positive, ...], Field(max_length=MOST_FREQUENCIES), AfterValidator(rising)
]


class ResonatorRecord(Record):
    """Resonator that rejects loads of one frequency, as an integral rejects a constant load.

    The two gains are in units of the command per unit of the error and s.
    """

    frequency_rad_s: Positive  # frequency of the loads that are rejected [rad/s]
    in_phase: Finite  # gain in phase with the error [command/(error s)]
    quadrature: Finite  # gain 90 degrees ahead of the error [command/(error s)]


def rising_resonators(resonators: tuple[ResonatorRecord, ...]) -> tuple[ResonatorRecord, ...]:
    """Return ``resonators``; ValueError if their frequencies do not rise as ``rising`` requires."""
    rising(tuple(one.frequency_rad_s for one in resonators))
    return resonators


def too_fast(frequencies: Sequence[float], sample_time: float) -> str | None:
    """Return a message if the highest frequency is too high for the sampling, or None."""
    half = math.pi / sample_time
    if not frequencies or frequencies[-1] < half:
        return None
    return f"must be below {half:.6g} rad/s, half the sampling frequency (got {frequencies[-1]:g})"


Resonators = Annotated[
    tuple[ResonatorRecord, ...],
    Field(max_length=MOST_FREQUENCIES),
    AfterValidator(rising_resonators),
]


class FeedForwardRecord(Record):
    """Feed-forward commands for the motion of the reference and for a load."""

    velocity: Finite = 0.0  # gain on the velocity of the reference [command s/error]
    acceleration: Finite = 0.0  # gain on the reference's acceleration [command s2/error]
    #: command in the direction of the reference, against Coulomb friction [command]
    coulomb: Finite = 0.0
    #: speed of the reference at which coulomb is full [error/s]; left out: no Coulomb part
    coulomb_width: Positive | None = None
    load: Finite = 0.0  # gain on the expected load [command/load]
    expected_load: Finite = 0.0  # expected load [load]

    @model_validator(mode="after")
    def _has_a_width(self) -> "FeedForwardRecord":
        if self.coulomb and self.coulomb_width is None:
            meaning = "the speed at which coulomb reaches its full value"
            raise ValueError(f"coulomb_width: is missing, {meaning}")
        return self


def with_own_signals(described: Any) -> Any:
    """Return ``described``; ValueError if ``signals`` names one of ``ERRORS`` or ``FOLLOWED``."""
    for name in (*ERRORS, *FOLLOWED):
        if name in described.signals:
            raise ValueError(f"signals.{name}: must be left out; see kp, kd and feed_forward")
    return described


def resonator_name(k: int) -> str:
    """Return the name of resonator ``k`` (from 0 on) among searched numbers and weights."""
    return f"resonator_{k + 1}"


#: Filters of a command, in this order, by their keys, which are also names of searched numbers.
FILTERS = {"notch": ("notch_hz", "notch_width", "notch_depth"), "lowpass": ("lowpass_hz",)}
Hz = Annotated[Positive | None, Field(exclude_if=not_)]


def filters_of(values: Mapping[str, Any], every: float) -> dict[str, Floats]:
    """Return the numbers of filters by kind, from ``values`` that may have other keys too."""
    keys = {kind: names for kind, names in FILTERS.items() if values.get(names[0]) is not None}
    return {kind: section(every, *(values[x] for x in names)) for kind, names in keys.items()}


class FilteredRecord(ControllerRecord):
    """Controller whose command can pass a notch and a low-pass."""

    notch_hz: Hz = None  # centre of a notch in the command [Hz]; left out: no notch
    #: its width at 3 dB, as a share of notch_hz [1]
    notch_width: Annotated[Positive, Field(exclude_if=(0.5).__eq__)] = 0.5
    #: gain of the notch at notch_hz [1]
    notch_depth: Annotated[float, Field(ge=0, le=1, exclude_if=(0.1).__eq__)] = 0.1
    lowpass_hz: Hz = None  # cut-off of a Butterworth low-pass of the command [Hz]; left out: none

    @model_validator(mode="after")
    def _filters_below_half_the_rate(self) -> Self:
        for key in ("notch_hz", "lowpass_hz"):
            if (hz := getattr(self, key) or 0.0) >= (half := 0.5 / self.sample_time_s):
                raise ValueError(f"{key} = {hz}: must be below {half:g} Hz, half the sampling rate")
        return self

    @property
    def filters(self) -> dict[str, Floats]:
        """Numbers of the filters by kind."""
        return filters_of(dict(self), self.sample_time_s)


class LinearDesign(FilteredRecord):
    """Common base of the linear kinds; every gain in units of the command."""

    kp: Finite  # gain on the error [command/error]
    ki: Finite = 0.0  # gain on the integral of the error [command/(error s)]
    kd: Finite = 0.0  # gain on the rate of the error [command s/error]
    #: cut-off frequency of the filter before kd [Hz]; 0 or left out: no filter
    derivative_hz: NotNegative | None = None
    signals: dict[Label, Finite] = {}  # gains on signals of the drive's sensors [command/signal]
    feed_forward: FeedForwardRecord = FeedForwardRecord()  # feed-forward gains
    resonators: Resonators = Field((), exclude_if=not_)  # one for each frequency of a periodic load

    explain = later(".code", "EXPLAIN")
    sections = later(".section", "sections")

    _signals_fit = model_validator(mode="after")(with_own_signals)

    @model_validator(mode="after")
    def _samples_tell_its_frequencies(self) -> "LinearDesign":
        if fault := too_fast([x.frequency_rad_s for x in self.resonators], self.sample_time_s):
            raise ValueError(f"resonators: {fault}")
        return self

    def reads(self) -> list[str]:
        """Signals that the controller reads in a sample."""
        return [*ERRORS, *self.signals, *AHEAD]

    def input_range(self, limit: float | None) -> dict[str, float]:
        """Return for each signal the value that alone commands the limit; 1 without a limit."""
        ahead = self.feed_forward
        gains = {"error": self.kp, "error_rate": self.kd, **self.signals}
        gains |= {"reference_rate": ahead.velocity, "reference_acceleration": ahead.acceleration}
        whole = {"reference_rate": ahead.coulomb_width} if ahead.coulomb_width else {}
        return whole | input_ranges(gains, limit)

    def connecting(self) -> list[str]:
        """Return a note on the filter of the error's rate."""
        if not self.derivative_hz:
            return ["`error_rate` is not filtered inside."]
        cut = f"a low-pass of the first order at {self.derivative_hz!r} Hz before its gain"
        return [f"`error_rate` passes {cut}: do not filter it again."]

    @property
    def filter_pole(self) -> float:
        """Share of the filtered rate that a sample keeps: a sampled first-order lag."""
        if not self.derivative_hz:
            return 0.0
        return math.exp(-2.0 * math.pi * self.derivative_hz * self.sample_time_s)

    def law_gains(self) -> LinearGains:
        """Return the gains of the design, as those of one individual."""
        ahead = self.feed_forward
        return LinearGains(
            self.kp,
            self.ki,
            self.kd,
            self.filter_pole,
            tuple(self.signals.values()) or None,
            ahead.velocity,
            ahead.acceleration,
            ahead.coulomb,
            ahead.coulomb_width or 1.0,
            ahead.load * ahead.expected_load,
            tuple((one.in_phase, one.quadrature) for one in self.resonators),
            tuple(tuple(x.tolist()) for x in self.filters.values()),
        )

    def law(self, limit: float | None) -> AxisLaw:
        """Return the law of one axis."""
        return AxisLaw(sample, initial_memory, self.sample_time_s, limit, self.form)

    @staticmethod
    def of_gains(gains: dict[str, float]) -> Json:
        """Return ``gains`` as keys of a record; a time constant ``derivative_s`` is converted."""
        if not gains.get("derivative_s"):
            return gains
        hz = 1.0 / (2.0 * math.pi * gains["derivative_s"])
        return {"derivative_hz": hz} | {k: x for k, x in gains.items() if k != "derivative_s"}

    @property
    def form(self) -> Structure:
        """Structure of the law."""
        angles = [x.frequency_rad_s * self.sample_time_s for x in self.resonators]
        turns = tuple((math.cos(x), math.sin(x)) for x in angles)
        return Structure(tuple(self.signals), turns, tuple(self.filters))


class PidDesign(LinearDesign):
    """Design of kind ``pid+ff``."""

    kind: Literal["pid+ff"] = "pid+ff"
    summary = "PID with filter and feed-forward"
    settings = later(".record", "PidSettings")
    genome = later(".genome", "PidGenome")


class WeightedDesign(LinearDesign):
    """Design with gains that minimise a sum of squares of weighted signals and of the command."""

    #: command that costs as much as a unit of the signal [command/signal]; for information only
    weights: dict[Label, NotNegative] = {}
    genome = later(".lq_genome", "LqGenome")


class LqrDesign(WeightedDesign):
    """Design of kind ``lqr``."""

    kind: Literal["lqr"] = "lqr"
    summary = "optimal state feedback with feed-forward"
    settings = later(".record", "LqrSettings")


class LqiDesign(WeightedDesign):
    """Design of kind ``lqi``."""

    kind: Literal["lqi"] = "lqi"
    summary = "optimal state feedback with integral and feed-forward"
    settings = later(".record", "LqiSettings")


class LinearSettings(ControllerSettings):
    """Settings of a search for a linear controller: what it reads and which numbers may vary."""

    #: signals of the drive fed back in addition to error and error_rate; left out: all
    signals: tuple[Label, ...] | None = None
    #: search ranges [low, high], where they differ from those of the nominal drive [of the number]
    ranges: dict[Label, Pair] = {}
    #: speed at which the drive is linearised [error/s]; left out: where it slides
    speed: Positive | None = None
    #: speed at which the Coulomb feed-forward is full [error/s]; left out: it is searched too
    coulomb_width: Positive | None = None
    expected_load: Finite = 0.0  # expected load, which is fed forward [load]
    #: frequencies of periodic loads or errors, with a resonator for each [rad/s]
    load_frequencies_rad_s: Frequencies = Field((), exclude_if=not_)
    notch: bool = Field(False, exclude_if=not_)  # whether a notch in the command is searched
    lowpass: bool = Field(False, exclude_if=not_)  # whether a low-pass of the command is searched

    @property
    def filters(self) -> tuple[str, ...]:
        """Names of the filters' numbers among the searched ones."""
        return tuple(x for kind, names in FILTERS.items() if getattr(self, kind) for x in names)

    @property
    def staged(self) -> bool:
        """True: a search has one stage, with all searched numbers."""
        return True

    def names(self, signals: list[str]) -> list[str]:
        """Return names of all numbers that may be searched on a drive with these signals."""
        return [*signals, *FORWARD, "coulomb_width", *self.resonators, *self.filters]

    @property
    def resonators(self) -> tuple[str, ...]:
        """Names of the resonators among the searched numbers."""
        return tuple(map(resonator_name, range(len(self.load_frequencies_rad_s))))

    def fault(self, target: Target) -> str | None:
        """Return a message on unfit signals, an unknown range or too high a frequency, or None."""
        if fault := too_fast(self.load_frequencies_rad_s, target.sample_time):
            return f"controller.load_frequencies_rad_s: {fault}"
        for drive in target.machine.drives:
            drive_signals = [name for name in drive.inputs if name not in ERRORS]
            for name in self.signals or ():
                if name not in drive_signals:
                    no_signal = f"controller.signals: {name!r}: unknown signal of the {drive.name}"
                    return f"{no_signal}; {one_of(name, drive_signals)}"
            known = self.names(drive_signals)
            for name in self.ranges:
                if name not in known:
                    return f"controller.ranges.{name}: unknown; {one_of(name, known)}"
        if len(set(self.signals or ())) < len(self.signals or ()):
            return "controller.signals: must have different names"
        return None


class PidSettings(LinearSettings):
    """Settings of a search for a PID with feed-forward; without signals unless they are named."""

    kind: Literal["pid+ff"]
    #: signals of the drive that are fed back beside error and error_rate
    signals: tuple[Label, ...] = ()
    #: form of the control that takes the gains as parameters: without filter; in a cascade of P and
    #: PI also without feed-forward of velocity and friction, and ki at most kp^2 / (4 kd)
    control: Literal["pid", "cascade"] | None = None

    def names(self, signals: list[str]) -> list[str]:
        """Return names of all searched numbers, with those of PID, filter and resonators' leads."""
        leads = (f"{name}{LEAD}" for name in self.resonators)
        return ["kp", "ki", "kd", "derivative_hz", *super().names(signals), *leads]


class WeightedSettings(LinearSettings):
    """Settings of an optimal regulator; without ``signals`` it reads all signals of the drive."""

    #: value of each signal that costs as much as the largest command where the search starts
    #: (Bryson's rule) [signal]
    tolerances: dict[Label, Positive] = {}

    def names(self, signals: list[str]) -> list[str]:
        """Return names of all searched numbers, with the weights of error and error_rate."""
        return [*ERRORS, *super().names(signals)]

    def fault(self, target: Target) -> str | None:
        """Return a message also on an unknown tolerance, or on one without a largest command."""
        if fault := super().fault(target):
            return fault
        drive = target.machine.drives[0]
        known = self.names([name for name in drive.inputs if name not in ERRORS])
        further = (*FORWARD, "coulomb_width", *self.resonators, *self.filters)
        weighted = [name for name in known if name not in further]
        for name in self.tolerances:
            if name not in weighted:
                message = f"controller.tolerances.{name}: unknown"
                return f"{message}; available: {', '.join(weighted)}"
        limit = next(iter(target.limits.values()))
        if self.tolerances and math.isinf(drive.largest_commands(target.parameters[0], limit)[1]):
            return "controller.tolerances: needs limits.command (the largest command)"
        return None


class LqrSettings(WeightedSettings):
    """Settings of a search for an optimal regulator."""

    kind: Literal["lqr"]


class LqiSettings(WeightedSettings):
    """Settings of a search for an optimal regulator with the integral of the error."""

    kind: Literal["lqi"]

    def names(self, signals: list[str]) -> list[str]:
        """Return names of all searched numbers, with the weight of the integral."""
        return ["integral", *super().names(signals)]
