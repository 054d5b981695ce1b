"""Adaptive fuzzy sliding control in a design file. Never imports JAX."""

from operator import add, not_
from typing import Literal, Self

import numpy as np
from pydantic import Field, model_validator

from hfc_design.controllers.fuzzy_sliding.law import Pid, SlidingGains, SlidingMemory
from hfc_design.controllers.kind import ControllerRecord
from hfc_design.core.numbers import Floats, each
from hfc_design.core.records import ZR, Finite, NotNegative, Positive, Record, Table

#: Linguistic labels of LG09 Table 2, negative large to positive large.
LABELS = ("LN", "MN", "SN", "ZZ", "SP", "MP", "LP")


class SurfaceRecord(Record):
    """The sliding surface ``s = de/dt + lambda e`` and the part that pushes towards it."""

    slope: Positive  # lambda of the sliding surface s = de/dt + lambda e [1/s]
    gain: NotNegative  # k = F + eta of LG09 eq. 11, F a constant [command]
    boundary_layer: Positive  # phi, the size of s up to which switching is smooth [error/s]


class ErrorDynamicsRecord(Record):
    """``d2e/dt2 + gains[1] de/dt + gains[0] e = 0`` and Q of its Lyapunov equation."""

    #: k_2 [1/s2] and k_1 [1/s] of the error's own dynamics [1/s2, 1/s]
    gains: tuple[Positive, Positive]
    weights: tuple[tuple[Finite, Finite], tuple[Finite, Finite]]  # Q of the Lyapunov equation [1]

    @model_validator(mode="after")
    def _is_definite(self) -> Self:
        (a, b), (c, d) = self.weights
        if b != c or not (a > 0.0 and a * d > b * c):
            raise ValueError(
                f"weights = [[{a}, {b}], [{c}, {d}]]: has to be symmetric and positive definite"
            )
        return self

    def last_column(self) -> tuple[float, float]:
        """P_2 of LG09 eq. 14: the last column of P in ``A' P + P A = -Q``."""
        from scipy.linalg import solve_continuous_lyapunov  # which takes a while to import

        near, far = self.gains
        companion: Floats = np.array([[0.0, 1.0], [-near, -far]])
        found: Floats = solve_continuous_lyapunov(companion.T, -np.array(self.weights))
        return float(found[0, 1]), float(found[1, 1])


class AdaptationRecord(Record):
    """How the consequents learn."""

    rate: NotNegative  # gamma, how fast consequents are learnt, LG09 eq. 14 [command/error]
    largest_move: NotNegative  # of a consequent from where it began, either way [command]
    #: left out: both poles at -lambda, and the Q for which ``E' P_2`` is s
    error_dynamics: ErrorDynamicsRecord | None = Field(None, exclude_if=not_)
    #: of the consequents, that have been learnt so far [command]
    moves: Table | None = Field(None, exclude_if=not_)


class PidRecord(Record):
    """Linear gains beside the rules."""

    k_p: Finite = 0.0  # on the error [command/error]
    k_i: Finite = 0.0  # on its integral [command/(error s)]
    k_d: Finite = 0.0  # on its rate [command s/error]


class SlidingDesign(ControllerRecord):
    """A controller of kind ``fuzzy-sliding``."""

    kind: Literal["fuzzy-sliding"] = "fuzzy-sliding"
    largest_error: Positive  # centre of LP; that of LN is the same below zero [error]
    largest_error_rate: Positive  # the same of its rate [error/s]
    #: what each rule says; rows: error, columns: its rate, both LN to LP [command]
    consequents: Table
    sliding: SurfaceRecord  # the switching part
    adaptation: AdaptationRecord  # how the consequents are learnt
    pid: PidRecord | None = Field(None, exclude_if=not_)  # PID beside it; left out: none

    @model_validator(mode="after")
    def _moved_within(self) -> Self:
        learning = self.adaptation
        for i, row in enumerate(learning.moves or ()):
            for j, move in enumerate(row):
                if abs(move) > learning.largest_move:
                    allowed = f"at most largest_move = {learning.largest_move} either way"
                    raise ValueError(f"adaptation.moves.{i}.{j} = {move}: has to be {allowed}")
        return self

    def judge(self) -> tuple[float, float]:
        """P_2: what an error [1/s] and its rate [1] count when the consequents are judged."""
        own = self.adaptation.error_dynamics
        return (self.sliding.slope, 1.0) if own is None else own.last_column()

    def reach(self, limit: float | None) -> dict[str, float]:
        """Up to the outermost centres."""
        return {"error": self.largest_error, "error_rate": self.largest_error_rate}

    def gains(self) -> SlidingGains:
        """The gains of one individual."""
        surface, learning = self.sliding, self.adaptation
        return SlidingGains(
            ZR / self.largest_error,
            ZR / self.largest_error_rate,
            self.table(),
            surface.slope,
            surface.gain,
            surface.boundary_layer,
            learning.rate,
            self.judge(),
            learning.largest_move,
            Pid(**dict(self.pid)) if self.pid else None,
            learning.moves,
        )

    def table(self) -> Table:
        """The consequents as they are by now [command]."""
        moves = self.adaptation.moves
        return tuple(map(tuple, each(add, self.consequents, moves))) if moves else self.consequents

    @property
    def learns(self) -> bool:
        """Whether a consequent can move."""
        return self.adaptation.rate > 0.0 and self.adaptation.largest_move > 0.0

    def adapted(self, memory: SlidingMemory) -> Self | None:
        """The controller with what ``memory`` has learnt; None where it learns nothing."""
        before = self.adaptation.moves
        moves = each(add, before, memory.moves) if before else memory.moves
        rows = tuple(tuple(map(float, row)) for row in moves)
        return self.with_moves(rows) if self.learns else None

    def with_moves(self, moves: Table) -> Self:
        """The same that has learnt so much."""
        learning = self.adaptation.model_copy(update={"moves": moves})
        return self.model_copy(update={"adaptation": learning})

    def held(self) -> Self:
        """The same without adaptation."""
        learning = self.adaptation.model_copy(update={"rate": 0.0})
        return self.model_copy(update={"adaptation": learning})
