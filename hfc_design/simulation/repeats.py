"""Repeats of a motion, each with the command changed by up to a millionth.

A loop that is not chaotic gives the same results for all. In a chaotic one the last bits decide, so
that a single value is one draw of many: it is shown as a range, and ranked by the lower end of the
range.
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
#: Change, as a share, from which on one figure does not stand for all of them.
CHAOS = 0.01
#: What the repeats are, for people.
TOLD = f"in {len(FACTORS)} repeats with the command changed by up to one millionth"


class ScaledCommand(NamedTuple):
    """A controller with a multiplied command; its gains are the factor and the controller's own."""

    inner: Controller

    @property
    def kind(self) -> str:
        """Name of the kind of the controller itself."""
        return self.inner.kind

    def initial_memory(self, zero: Scalar) -> Memory:
        """Memory of the controller itself before the first sample."""
        return self.inner.initial_memory(zero)

    def begun(self, xp: Xp, zero: Scalar, gains: Gains) -> Memory:
        """Memory of the controller itself with its gains."""
        return begun(self.inner, xp, zero, gains[1])

    def step(self, xp: Xp, gains: Gains, memory: Memory, view: View) -> Stepped:
        """The controller's commands, times the factor."""
        factor, inner_gains = gains
        commands, memory = self.inner.step(xp, inner_gains, memory, view)
        return tuple(factor * command for command in commands), memory


def scaled_command(loop: Loop, gains: Gains, factors: Floats = FACTORS) -> tuple[Loop, Gains]:
    """The loop of one individual as many, (factors,), each with a factor on the command."""
    wide = jax.tree.map(lambda leaf: np.repeat(leaf, len(factors), axis=-1), gains)
    return loop._replace(controller=ScaledCommand(loop.controller)), (factors, wide)


class Repeats(NamedTuple):
    """Fitness or merit of every repeat."""

    values: Floats  # (FACTORS,) the loop as it is first; -inf where one failed

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
        """Whether the repeats differ by more than ``CHAOS`` from the unchanged loop.

        An unchanged loop that fails has failed, and is not called chaotic.
        """
        base = self.values[0]
        return bool(np.isfinite(base)) and not self.highest - self.lowest <= CHAOS * abs(base)

    @property
    def worth(self) -> float:
        """Value that ranks a design: that of the unchanged loop, or the lowest if chaotic."""
        return self.lowest if self.chaotic else float(self.values[0])

    def numbers(self) -> Json:
        """Return plain data; None where a repeat failed."""
        # Not interpolated: between one that failed and one that did not there is nothing.
        median = float(np.quantile(self.values, 0.5, method="lower"))
        ends = {"lowest": self.lowest, "median": median, "highest": self.highest}
        return storable(ends) | {"count": len(self.values)}


#: Of an evaluation: of its fitness and its merit.
Each = Mapping[str, Repeats]


def repeats_of(judged: Judged) -> dict[str, Repeats]:
    """Repeats of individuals that differ by ``FACTORS``, (FACTORS,) each."""
    values = {"fitness": np.asarray(judged.values)[:, 0], "merit": np.asarray(judged.merit)}
    failed = np.asarray(judged.failed)
    each = {key: np.where(failed | ~np.isfinite(x), -np.inf, x) for key, x in values.items()}
    return {key: Repeats(x) for key, x in each.items()}


def together(each: Sequence[Each], weights: Floats) -> dict[str, Repeats]:
    """Combine the repeats of several motions into those of one, repeat by repeat."""
    stacked = {key: np.stack([one[key].values for one in each], axis=1) for key in each[0]}
    return {key: Repeats(averaged(values, weights)) for key, values in stacked.items()}


def averaged(merits: Floats, weights: Floats) -> Floats:
    """(n,) weighted means of merits (n, motions), taken of the costs, which are their inverses.

    -inf where a motion failed, 0 where one is worth nothing.
    """
    with np.errstate(all="ignore"):
        mean_merit = weights.sum() / ((1.0 / merits) @ weights)
    worst = merits.min(axis=1)
    return np.where(worst > 0.0, mean_merit, np.where(worst == -np.inf, -np.inf, 0.0))


def of_all_motions(scenario: Scenario, merits: Floats) -> Floats:
    """(n,) merits over all motions of a scenario, by its weights, from (n, motions)."""
    weights = np.array([motion.weight for motion in scenario.motions] or [1.0])
    return merits[:, 0] if merits.shape[1] == 1 else averaged(merits, weights)


def range_text(repeats: Json) -> str:
    """The range of a chaotic value in ``Repeats.numbers``, as words."""
    return f"{ends_text(repeats)} (chaotic)"


def chaos_text(what: str, repeats: Json) -> str:
    """A sentence on the chaotic fitness or merit, with its range."""
    return f"{what} is chaotic: {TOLD}, it ranges from {ends_text(repeats)}"


def ends_text(repeats: Json) -> str:
    """The ends of a range in ``Repeats.numbers``, as text."""
    low, high = (_short(repeats[end]) for end in ("lowest", "highest"))
    return f"{low} to {high}"


def _short(value: float | None) -> str:
    """Four digits, of a range that is one percent wide at least."""
    if value is None:
        return "diverged"
    return f"{value:.0f}" if 1e3 <= abs(value) < 1e7 else f"{value:.4g}"
