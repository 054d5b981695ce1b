"""Records of adaptive fuzzy sliding control in a design file. Never imports JAX."""

from math import isfinite
from operator import add, not_
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, field_validator, model_validator

from hfc_design.controllers.controller import AxisLaw
from hfc_design.controllers.fuzzy_sliding.law import Pid, SlidingGains, SlidingMemory, sliding
from hfc_design.controllers.kind import (
    ControllerRecord,
    ControllerSettings,
    Target,
    controller_named,
    later,
    sampled_otherwise,
)
from hfc_design.core.numbers import Floats, each
from hfc_design.core.records import ZR, Finite, Label, NotNegative, Positive, Record, Rules, ordered
from hfc_design.core.wording import one_of

#: Linguistic labels of LG09 Table 2, negative large to positive large.
LABELS = ("LN", "MN", "SN", "ZZ", "SP", "MP", "LP")


class SurfaceRecord(Record):
    """Sliding surface ``s = de/dt + lambda e`` and the switching part of the command."""

    slope: Positive  # lambda of the sliding surface s = de/dt + lambda e [1/s]
    gain: NotNegative  # k = F + eta of LG09 eq. 11, F a constant [command]
    boundary_layer: Positive  # phi, the size of s up to which switching is smooth [error/s]


class ErrorDynamicsRecord(Record):
    """Desired dynamics ``d2e/dt2 + gains[1] de/dt + gains[0] e = 0``, and Q (see last_column)."""

    #: k_2 [1/s2] and k_1 [1/s] of the desired error dynamics [1/s2, 1/s]
    gains: tuple[Positive, Positive]
    weights: tuple[tuple[Finite, Finite], tuple[Finite, Finite]]  # Q of the Lyapunov equation [1]

    @model_validator(mode="after")
    def _is_definite(self) -> Self:
        (a, b), (c, d) = self.weights
        if b != c or not (a > 0.0 and a * d > b * c):
            given = f"weights = [[{a}, {b}], [{c}, {d}]]"
            raise ValueError(f"{given}: must be symmetric and positive definite")
        return self

    def last_column(self) -> tuple[float, float]:
        """Return P_2 of LG09 eq. 14, the last column of P in ``A' P + P A = -Q``."""
        from scipy.linalg import solve_continuous_lyapunov  # here, because the import is slow

        near, far = self.gains
        companion: Floats = np.array([[0.0, 1.0], [-near, -far]])
        solution: Floats = solve_continuous_lyapunov(companion.T, -np.array(self.weights))
        return float(solution[0, 1]), float(solution[1, 1])


class AdaptationRecord(Record):
    """Learning of the consequents."""

    rate: NotNegative  # gamma, learning rate of the consequents, LG09 eq. 14 [command/error]
    #: largest move of a consequent from its start, in both directions [command]
    largest_move: NotNegative
    #: desired error dynamics; left out: both poles at -lambda, with the Q for which ``E' P_2`` is s
    error_dynamics: ErrorDynamicsRecord | None = Field(None, exclude_if=not_)
    #: moves of the consequents learned so far [command]
    moves: Rules | None = Field(None, exclude_if=not_)


class PidRecord(Record):
    """Linear gains in addition to the rules."""

    k_p: Finite = 0.0  # gain on the error [command/error]
    k_i: Finite = 0.0  # gain on the integral of the error [command/(error s)]
    k_d: Finite = 0.0  # gain on the rate of the error [command s/error]


class SlidingDesign(ControllerRecord):
    """Design of kind ``fuzzy-sliding``."""

    kind: Literal["fuzzy-sliding"] = "fuzzy-sliding"
    summary = "adaptive fuzzy rules plus a sliding mode with a boundary layer (Lin & Gai 2009)"
    settings = later(".record", "SlidingSettings")
    genome = later(".genome", "SlidingGenome")
    rule_base = later(".export", "RULES")
    steps_of_adaptation = ("rate",)
    explain = later(".export", "EXPLAIN")
    pictures = later(".pictures", "pictures")
    sections = later(".pictures", "sections")
    largest_error: Positive  # centre of the error's term LP; that of LN is its negative [error]
    largest_error_rate: Positive  # centre of the term LP of the error rate [error/s]
    #: output of each rule [command]; rows: error, columns: its rate, both LN to LP
    consequents: Rules
    sliding: SurfaceRecord  # the switching part
    adaptation: AdaptationRecord  # learning of the consequents
    pid: PidRecord | None = Field(None, exclude_if=not_)  # added PID; left out: none

    @model_validator(mode="after")
    def _moved_within(self) -> Self:
        learning = self.adaptation
        for i, row in enumerate(learning.moves or ()):
            for j, move in enumerate(row):
                if abs(move) > learning.largest_move:
                    allowed = f"between -largest_move and largest_move = {learning.largest_move}"
                    raise ValueError(f"adaptation.moves.{i}.{j} = {move}: must be {allowed}")
        return self

    def law(self, limit: float | None) -> AxisLaw:
        """Return the law of one axis."""
        return sliding(self.sample_time_s, limit)

    def judge(self) -> tuple[float, float]:
        """Return P_2: weights of the error [1/s] and of its rate [1] in the learning step."""
        dynamics = self.adaptation.error_dynamics
        return (self.sliding.slope, 1.0) if dynamics is None else dynamics.last_column()

    def input_range(self, limit: float | None) -> dict[str, float]:
        """Return the outermost centres of both inputs."""
        return {"error": self.largest_error, "error_rate": self.largest_error_rate}

    def law_gains(self) -> SlidingGains:
        """Return the gains of one individual."""
        surface, learning = self.sliding, self.adaptation
        return SlidingGains(
            ZR / self.largest_error,
            ZR / self.largest_error_rate,
            self.consequents,
            surface.slope,
            surface.gain,
            surface.boundary_layer,
            learning.rate,
            self.judge(),
            learning.largest_move,
            Pid(**dict(self.pid)) if self.pid else None,
            learning.moves,
        )

    def table(self) -> Rules:
        """Return the consequents with the moves learned so far [command]."""
        moves = self.adaptation.moves
        return tuple(map(tuple, each(add, self.consequents, moves))) if moves else self.consequents

    @property
    def learns(self) -> bool:
        """True if a consequent can move."""
        return self.adaptation.rate > 0.0 and self.adaptation.largest_move > 0.0

    def adapted(self, memory: SlidingMemory) -> Self | None:
        """Return the design with the moves learned in ``memory``; None if it cannot learn."""
        rows = tuple(tuple(map(float, row)) for row in memory.moves)
        return self.with_moves(rows) if self.learns else None

    def with_moves(self, moves: Rules) -> Self:
        """Return the design with the learned ``moves``."""
        learning = self.adaptation.model_copy(update={"moves": moves})
        return self.model_copy(update={"adaptation": learning})


#: LG09 Table 2 in thirds of LP: rows the error, columns its rate, both LN to LP.
TABLE_2 = (
    (-3, -3, -3, -3, -3, -3, -3),
    (-3, -3, -2, -2, -1, -1, -1),
    (-3, -2, -2, -1, -1, -1, 0),
    (0, 0, 0, 0, 0, 0, 0),
    (0, 1, 1, 1, 2, 2, 3),
    (1, 1, 1, 2, 2, 3, 3),
    (3, 3, 3, 3, 3, 3, 3),
)
#: Proportional gain of LG09 Table 1: speed divided by error [1/s].
GAIN = 33.33
#: Defaults if no start is given: switching part as a share of the largest command, boundary layer
#: as a share of the largest rate, time in which the largest error teaches the largest command [s].
SWITCHING, LAYER, LEARNING = 0.02, 0.05, 0.1


#: Searched numbers -> the factor by which each may be larger or smaller than in the start.
SEARCHED = {
    "largest_error": 10.0,
    "largest_error_rate": 10.0,
    "largest_consequent": 3.0,
    "slope": 10.0,
    "gain": 10.0,
    "boundary_layer": 10.0,
    "rate": 100.0,
    "largest_move": 10.0,
}


class SlidingSettings(ControllerSettings):
    """Settings of a search: the initial fuzzy sliding controller, and what may vary."""

    kind: Literal["fuzzy-sliding"]
    #: a design or a record; left out: LG09 Table 2 with the scales of the machine
    start: SlidingDesign | None = Field(None, exclude_if=lambda start: start is None)
    #: search ranges [low, high], where they differ from those around the start [of the number]
    ranges: dict[Label, Annotated[tuple[Finite, Finite], ordered]] = {}
    consequents: bool = False  # whether all consequents are searched too
    symmetric: bool = True  # whether both directions are treated alike

    _controller_of = field_validator("start", mode="before")(controller_named)

    @field_validator("ranges")
    @classmethod
    def _known(cls, ranges: dict[str, tuple[float, float]]) -> dict[str, tuple[float, float]]:
        for name in ranges:
            if name not in SEARCHED:
                raise ValueError(f"{name}: unknown; {one_of(name, SEARCHED)}")
        return ranges

    @property
    def staged(self) -> bool:
        """True: one stage with all searched numbers."""
        return True

    def fault(self, target: Target) -> str | None:
        """Return why the search is impossible (sample time, or unknown scales), or None."""
        if self.start is None:
            command, speed = scales(target)
            if not (isfinite(command) and isfinite(speed) and command > 0.0 and speed > 0.0):
                needed = "limits.command and a drive with a known top speed are needed"
                return f"controller.start: is missing; without it {needed}"
        return sampled_otherwise(self.start, target)


def scales(target: Target) -> tuple[float, float]:
    """Return the largest command and the largest speed that every axis of a machine reaches."""
    limits = target.limits.values()
    axes = list(zip(target.machine.drives, target.parameters, limits, strict=True))
    ends = (drive.largest_commands(parameters, limit) for drive, parameters, limit in axes)
    speeds = (float(drive.top_speed(parameters)) for drive, parameters, _ in axes)
    return min(abs(x) for pair in ends for x in pair), min(speeds)


def started(target: Target) -> SlidingDesign:
    """Return a design with LG09 Table 2, scaled to a machine with the gain of LG09 Table 1.

    LP of the output is the largest command, LP of the rate the top speed, and LP of the error the
    top speed divided by ``GAIN``. LG09 prints neither the sliding surface nor gamma.
    """
    command, speed = scales(target)
    error = speed / GAIN
    layer, rate = LAYER * GAIN * error, command / (GAIN * error * LEARNING)
    return SlidingDesign(
        sample_time_s=target.sample_time,
        largest_error=error,
        largest_error_rate=speed,
        consequents=tuple(tuple(command * third / 3.0 for third in row) for row in TABLE_2),
        sliding=SurfaceRecord(slope=GAIN, gain=SWITCHING * command, boundary_layer=layer),
        adaptation=AdaptationRecord(rate=rate, largest_move=command / 3.0),
    )
