"""Repeats of a motion, each with the command changed by up to a millionth.

A loop that is not chaotic has nearly the same result in all repeats. In a chaotic loop the last
bits of numbers decide, so that a single result is one of many possible ones: it is shown as a
range, and designs are ranked by the lower end of the range.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import jax
import numpy as np

from hfc_design.controllers.controller import Controller, Stepped, View, begun
from hfc_design.core.numbers import Floats, Gains, Json, Memory, Scalar, Xp, storable
from hfc_design.files.scenario import Scenario
from hfc_design.objectives.judge import Judged
from hfc_design.simulation.closed_loop import Loop

#: Factors on the whole command; the first one is the loop as it is.
FACTORS = np.append(1.0, 1.0 + 1e-6 * np.linspace(-1.0, 1.0, 63))
#: Relative range of the repeats above which a loop is called chaotic.
CHAOS = 0.01
#: Text that describes the repeats.
TOLD = f"in {len(FACTORS)} repeats with the command changed by up to one millionth"


class ScaledCommand(NamedTuple):
    """A controller whose commands are multiplied; its gains are (factor, gains of ``inner``)."""

    inner: Controller

    @property
    def kind(self) -> str:
        """Name of the kind of the inner controller."""
        return self.inner.kind

    def initial_memory(self, zero: Scalar) -> Memory:
        """Return the memory of the inner controller before the first sample."""
        return self.inner.initial_memory(zero)

    def begun(self, xp: Xp, zero: Scalar, gains: Gains) -> Memory:
        """Return the memory of the inner controller, with its gains, before the first sample."""
        return begun(self.inner, xp, zero, gains[1])

    def step(self, xp: Xp, gains: Gains, memory: Memory, view: View) -> Stepped:
        """Return the commands of the inner controller times the factor, and the new memory."""
        factor, inner_gains = gains
        commands, memory = self.inner.step(xp, inner_gains, memory, view)
        return tuple(factor * command for command in commands), memory


def scaled_command(loop: Loop, gains: Gains, factors: Floats = FACTORS) -> tuple[Loop, Gains]:
    """Return loop and gains of copies of one individual, each with one of ``factors``."""
    wide = jax.tree.map(lambda leaf: np.repeat(leaf, len(factors), axis=-1), gains)
    return loop._replace(controller=ScaledCommand(loop.controller)), (factors, wide)


class Repeats(NamedTuple):
    """Fitness or merit of every repeat."""

    values: Floats  # (FACTORS,) that of the unchanged loop first; -inf for a repeat that failed

    @property
    def lowest(self) -> float:
        """Lowest value, by which a chaotic design is ranked."""
        return float(self.values.min())

    @property
    def highest(self) -> float:
        """Highest value of all repeats."""
        return float(self.values.max())

    @property
    def chaotic(self) -> bool:
        """Whether the range of the repeats is above ``CHAOS`` times the unchanged loop's value.

        A loop that fails without a change is not called chaotic.
        """
        base = self.values[0]
        return bool(np.isfinite(base)) and not self.highest - self.lowest <= CHAOS * abs(base)

    @property
    def worth(self) -> float:
        """Value that ranks a design: that of the unchanged loop, or the lowest if it is chaotic."""
        return self.lowest if self.chaotic else float(self.values[0])

    def numbers(self) -> Json:
        """Return lowest, median and highest value and the count, for JSON; None: it has failed."""
        # Not interpolated: between a repeat that failed and another one there is no value.
        median = float(np.quantile(self.values, 0.5, method="lower"))
        ends = {"lowest": self.lowest, "median": median, "highest": self.highest}
        return storable(ends) | {"count": len(self.values)}


#: Repeats of an evaluation: "fitness" and "merit" -> values.
Each = Mapping[str, Repeats]


def repeats_of(judged: Judged) -> dict[str, Repeats]:
    """Return the repeats from the judge's results (FACTORS,) of ``scaled_command``."""
    values = {"fitness": np.asarray(judged.values)[:, 0], "merit": np.asarray(judged.merit)}
    failed = np.asarray(judged.failed)
    each = {key: np.where(failed | ~np.isfinite(x), -np.inf, x) for key, x in values.items()}
    return {key: Repeats(x) for key, x in each.items()}


def together(each: Sequence[Each], weights: Floats) -> dict[str, Repeats]:
    """Return the repeats over several motions, from those of each motion, repeat by repeat."""
    stacked = {key: np.stack([one[key].values for one in each], axis=1) for key in each[0]}
    return {key: Repeats(averaged(values, weights)) for key, values in stacked.items()}


def averaged(merits: Floats, weights: Floats) -> Floats:
    """Return weighted means (n,) of merits (n, motions): means of the costs, which are 1 / merit.

    A mean is -inf if a merit is -inf (the motion failed), and 0 if the lowest is not above 0.
    """
    with np.errstate(all="ignore"):
        mean_merit = weights.sum() / ((1.0 / merits) @ weights)
    worst = merits.min(axis=1)
    return np.where(worst > 0.0, mean_merit, np.where(worst == -np.inf, -np.inf, 0.0))


def of_all_motions(scenario: Scenario, merits: Floats) -> Floats:
    """Return merits (n,) over all motions of a scenario, by its weights, from (n, motions)."""
    weights = np.array([motion.weight for motion in scenario.motions] or [1.0])
    return merits[:, 0] if merits.shape[1] == 1 else averaged(merits, weights)


def range_text(repeats: Json) -> str:
    """Return a text with the range of a chaotic value, from ``Repeats.numbers``."""
    return f"{ends_text(repeats)} (chaotic)"


def chaos_text(what: str, repeats: Json) -> str:
    """Return a sentence on a chaotic fitness or merit (``what``), with its range."""
    return f"{what} is chaotic: {TOLD}, it ranges from {ends_text(repeats)}"


def ends_text(repeats: Json) -> str:
    """Return a text with the ends of a range in ``Repeats.numbers``."""
    low, high = (_short(repeats[end]) for end in ("lowest", "highest"))
    return f"{low} to {high}"


def _short(value: float | None) -> str:
    """Return a number as text with four digits or more: a range is at least one percent wide."""
    if value is None:
        return "diverged"
    return f"{value:.0f}" if 1e3 <= abs(value) < 1e7 else f"{value:.4g}"
