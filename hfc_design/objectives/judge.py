"""The judge of closed loops: one object for searches, final choices, scores and reports."""

from collections.abc import Callable, Sequence
from functools import cache
from operator import itemgetter
from typing import Annotated, NamedTuple, TypeAlias

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float
from pydantic import SerializeAsAny

from hfc_design import objectives
from hfc_design.core.numbers import Floats, Scalar
from hfc_design.core.plugins import Group, chosen, found_in, own_code
from hfc_design.motion.samples import PathFrame
from hfc_design.objectives.metric import Metric
from hfc_design.objectives.objective import Moment, Objective, ObjectiveSettings, Remaining, Sums
from hfc_design.objectives.stick_share import stick_share

#: Every objective by its name: those of the modules of this package, and those that users add.
OBJECTIVES: Group[Objective] = Group(
    "fitness", (Objective,), "hfc_design.fitness", found_in(objectives, "OBJECTIVE")
)
#: The ``[fitness]`` of a scenario.
FitnessSettings = Annotated[
    SerializeAsAny[ObjectiveSettings], chosen(OBJECTIVES, "settings", default="lin-lee")
]
Individuals: TypeAlias = Float[Array | np.ndarray, " individuals"]


class Judged(NamedTuple):
    """Results of a judge for a population of closed loops; NumPy arrays after the simulation."""

    merit: Individuals  # number that ranks them; meaningless for a failed individual
    values: Float[Array | np.ndarray, "individuals values"]  # of objectives, then ``measured``
    failed: Bool[Array | np.ndarray, " individuals"]  # a position, the merit or a value not finite

    @property
    def rows(self) -> list["Judged"]:
        """One object for each index of the first dimension of the arrays."""
        return [Judged(*row) for row in zip(*self, strict=True)]

    @classmethod
    def stacked(cls, rows: Sequence["Judged"]) -> "Judged":
        """Return one object of ``rows``, the inverse of ``rows``."""
        return cls(*(np.stack(parts) for parts in zip(*rows, strict=True)))

    @property
    def rank(self) -> Floats:
        """Merit (individuals,), but -inf for a failed individual, which ranks below all others."""
        return np.where(self.failed, -np.inf, self.merit)


class Judge(NamedTuple):
    """Objectives, and the function that combines them into the merit: the larger, the better."""

    objectives: tuple[Objective, ...]  # the fitness comes first
    merit: Callable[[list[Scalar]], Scalar]  # values of all objectives -> merit
    title: str  # of the merit, for readers of tables
    measured: tuple[Metric, ...] = ()  # metrics that are computed besides the objectives

    @property
    def titles(self) -> dict[str, str]:
        """Titles of an evaluation's values in tables: ``fitness`` and, if it differs, ``merit``."""
        fitness = self.objectives[0].label()
        merit = {"merit": f"merit: {self.title}"} if self.title != fitness else {}
        return {"fitness": fitness} | merit

    @property
    def wordless(self) -> "Judge":
        """The judge without its texts, which contain numbers."""
        objectives = tuple(one.wordless for one in self.objectives)
        measured = tuple(one.wordless for one in self.measured)
        return Judge(objectives, self.merit, "", measured)

    @property
    def _parts(self) -> list[Objective | Metric]:
        return [*self.objectives, *self.measured]

    def initial(self, zero: Scalar) -> tuple[Sums, ...]:
        """Return the empty sums of all objectives and of ``measured``."""
        return tuple(one.initial(zero) for one in self._parts)

    def update(
        self, sums: tuple[Sums, ...], moments: tuple[Moment, ...], path: PathFrame | None
    ) -> tuple[Sums, ...]:
        """Return the sums with one more sample of every axis."""
        pairs = zip(self._parts, sums, strict=True)
        return tuple(one.update(totals, moments, path) for one, totals in pairs)

    def values(self, sums: tuple[Sums, ...]) -> list[Scalar]:
        """Return the value of each objective, from its sums."""
        return [one.score(totals) for one, totals in zip(self.objectives, sums, strict=True)]

    def best(self, sums: tuple[Sums, ...], left: Remaining) -> Individuals:
        """Return the highest merit that each individual can still reach; infinite: unknown.

        It is the merit of the best values, because a merit grows with every objective.
        """
        pairs = [*zip(self.objectives, sums, strict=False)]
        if any(one.best is None for one, _ in pairs):
            return jnp.full_like(jnp.asarray(jax.tree.leaves(sums)[0]), jnp.inf)
        return self.merit([one.best(totals, left) for one, totals in pairs if one.best])

    def judged(self, sums: tuple[Sums, ...], positions: list[Individuals]) -> Judged:
        """Return the results, from the sums and the last position (individuals,) of each axis."""
        count = len(self.objectives)
        values = self.values(sums[:count])
        merit = self.merit(values)
        values += [
            one.value(totals) for one, totals in zip(self.measured, sums[count:], strict=True)
        ]
        finite = jnp.isfinite(jnp.stack([merit, *values, *positions]))
        return Judged(merit, jnp.stack(values, axis=-1), ~finite.all(axis=0))


@cache
def judge(fitness: Objective, stick_penalty: float) -> Judge:
    """Return the judge by ``fitness / (1 + stick_penalty * stick share)``; if negative: times."""
    if not stick_penalty:
        return Judge((fitness,), itemgetter(0), fitness.label())
    worse = " /" if fitness.positive else ", divided by"
    title = fitness.label(f"{worse} (1 + {stick_penalty:g} stick share)")
    return Judge((fitness, stick_share(stick_penalty)), _worse_by_cost, title)


def _worse_by_cost(values: list[Scalar]) -> Scalar:
    fitness, cost = values
    factor = 1.0 - cost
    return jnp.where(fitness < 0.0, fitness * factor, fitness / factor)


def objective_of(settings: ObjectiveSettings) -> Objective:
    """Return the objective with these settings; UserError: a user's own ``make`` fails."""
    objective = OBJECTIVES.get(settings.kind)
    with own_code(": make", ("fitness", objective.name)):
        return Objective(*objective.make(settings)) if objective.make else objective
