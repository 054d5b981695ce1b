"""A user's own kind: a table over the error that learns while it runs, beside an integral.

``hfc design SCENARIO --controller toy_kind:KIND`` searches its heights. Everything about it is in
this folder; nothing in the package knows it.
"""

from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import Field

import hfc_design.api as hfc

POINTS = 5


class Gains(NamedTuple):
    """One individual, or a population in the trailing axis."""

    heights: Any  # (5,) command at errors of -2, -1, 0, 1, 2 widths
    width: Any  # of the error between two points
    integral: Any  # integral gain
    rate: Any  # by which a point learns, a sample


class Memory(NamedTuple):
    """What it remembers; all zero before the first sample."""

    moves: Any  # (5,) of the points
    sum: Any  # of the integral


class Parts(NamedTuple):
    """What the command is made of."""

    place: Any  # of the error in the table
    weights: list[Any]  # (5,)
    table: list[Any]  # (5,) heights as they are at this sample
    inferred: Any
    integral: Any


def start(law: hfc.AxisLaw, zero: Any) -> Memory:
    """Nothing learnt."""
    return Memory((zero,) * POINTS, zero)


def sample(xp: hfc.Xp, law: hfc.AxisLaw, gains: Gains, memory: Memory, signals: Any) -> Any:
    """Linear between the points, constant beyond; the points that act learn from the error."""
    error = signals["error"]
    place = hfc.clipped(xp, error / gains.width, -2.0, 2.0)
    weights = [xp.maximum(1.0 - abs(place - (k - 2.0)), 0.0) for k in range(POINTS)]
    table = [h + move for h, move in zip(gains.heights, memory.moves, strict=True)]
    inferred = hfc.total(w * h for w, h in zip(weights, table, strict=True))
    summed = memory.sum + gains.integral * law.sample_time * error
    summed = hfc.held(xp, law.limit, inferred + summed, memory.sum, summed)
    moves = tuple(
        move + gains.rate * w * error for move, w in zip(memory.moves, weights, strict=True)
    )
    parts = Parts(place, weights, table, inferred, summed)
    return inferred + summed, Memory(moves, summed), parts


Heights = Annotated[tuple[float, ...], Field(min_length=POINTS, max_length=POINTS)]


class Settings(hfc.ControllerSettings):
    """What a search varies."""

    kind: Literal["toy"]
    width: Annotated[float, Field(gt=0)] = 1.0
    largest: Annotated[float, Field(gt=0)] = 10.0
    integral: float = 0.0
    rate: float = 0.0


class Tables(NamedTuple):
    """n individuals; every array carries them in its leading axis."""

    tree: np.ndarray  # (n,) 0
    heights: np.ndarray  # (n, 5)


class Genome(hfc.Genome):
    """How tables begin and vary."""

    def empty(self) -> Tables:
        """One table of zeros."""
        return Tables(np.zeros(1, int), np.zeros((1, POINTS)))

    def fresh(self, tree: Any, rng: np.random.Generator) -> Tables:
        """Rising tables."""
        steps = rng.uniform(0.0, self.settings.largest / 2, (len(tree), POINTS))
        return Tables(tree, np.cumsum(steps, axis=1) - np.cumsum(steps, axis=1)[:, 2:3])

    def mutated(self, population: Tables, step: Any, rng: np.random.Generator) -> Tables:
        """Other heights."""
        moved = rng.standard_normal(population.heights.shape) * self.settings.largest
        return population._replace(heights=population.heights + step[:, None] * moved)

    def blended(self, one: Tables, other: Tables, share: Any) -> Tables:
        """Heights on a straight line."""
        line = one.heights + share[:, None] * (other.heights - one.heights)
        return one._replace(heights=line)

    def nudged(self, population: Tables, rng: np.random.Generator) -> Tables:
        """Heights a millionth off."""
        return population._replace(heights=population.heights * (1.0 + 1e-6))

    def gains(self, population: Tables) -> Gains:
        """As the simulator wants them."""
        s, count = self.settings, len(population.tree)
        same = (np.full(count, value) for value in (s.width, s.integral, s.rate))
        return Gains(population.heights.T, *same)

    def record(self, individual: Tables) -> dict[str, Any]:
        """As a design file has it, without the sample time."""
        s = self.settings
        heights = individual.heights[0].tolist()
        return {
            "kind": "toy",
            "heights": heights,
            "width": s.width,
            "integral": s.integral,
            "rate": s.rate,
        }


def shown(record: Any, parts: Parts) -> dict[str, Any]:
    """Which points of the table act."""
    rules = [
        {"row": str(k - 2), "column": "-", "strength": w, "share": w, "consequent": height}
        for k, (w, height) in enumerate(zip(parts.weights, parts.table, strict=True))
        if w > 0.0
    ]
    place = {"input": "error", "value": float(parts.place), "degrees": {"0": 1.0}}
    unit = {"unit": "table", "column": place, "row": place, "rules": rules, "output": 0.0}
    return {"units": [unit], "parts": {"fuzzy": parts.inferred, "integral": parts.integral}}


class Design(hfc.ControllerRecord):
    """A controller of this kind in a design file."""

    kind: Literal["toy"] = "toy"
    summary = "a table over the error that learns"
    settings = Settings
    genome = Genome
    explain = hfc.Explain(lambda record: (["error"], []), lambda memory, readings: memory, shown)
    heights: Heights
    width: Annotated[float, Field(gt=0)]
    integral: float = 0.0
    rate: float = 0.0

    def law_gains(self) -> Gains:
        """The numbers."""
        return Gains(self.heights, self.width, self.integral, self.rate)

    def law(self, limit: float | None) -> hfc.AxisLaw:
        """The law of one axis."""
        return hfc.AxisLaw(sample, start, self.sample_time_s, limit)

    def reads(self) -> list[str]:
        """Nothing else."""
        return ["error"]

    def adapted(self, memory: Memory) -> "Design":
        """With the table that it has learnt."""
        table = tuple(h + move for h, move in zip(self.heights, memory.moves, strict=True))
        return self.model_copy(update={"heights": table})

    def sections(self, shown: hfc.Shown) -> list[Any]:
        """Its table."""
        unit = shown.units["command"]
        rows = [[f"{k - 2}", f"{height:.4g}", unit] for k, height in enumerate(self.heights)]
        listing = hfc.Listing("The learnt table.", ["place", "command", "unit"], rows)
        return [hfc.Section("A table of its own", "", listing, [])]


KIND = Design
