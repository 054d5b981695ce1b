"""Polish of the design of a finished search: ranking, derivatives and checkpoints of the polish.

A stopped polish is resumed from a checkpoint in the folder of the run.
"""

from collections.abc import Callable
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from hfc_design.controllers.genome import Population, taken
from hfc_design.core import archive, checkpoint
from hfc_design.core.numbers import Floats, Integers, storable
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.files.scenario import Scenario
from hfc_design.objectives.verdict import Ensemble
from hfc_design.runs import stored
from hfc_design.runs.champion import LEAST_VIOLATED
from hfc_design.runs.individuals import design_of, genome_of, noted, with_score
from hfc_design.runs.problem import final_problem
from hfc_design.search.coordinates import coordinates
from hfc_design.search.polish import Polishable, Polished, Quadratic, polish
from hfc_design.simulation import population as simulate
from hfc_design.simulation.error_weights import RECORDED, Traces, motion_slopes
from hfc_design.simulation.evaluating import Evaluation, evaluate

CHECKPOINT = "polish.npz"
#: Key in the score of a design for the number of steps, and the rank before and after them.
POLISH = "polish"
#: Number of copies, changed by a millionth, that show whether an individual is good by luck only.
DOUBLES = 7
#: With several machines, a step uses the nominal one, ``HARD`` on which the initial design is
#: closest to a violation, and ``RANDOM`` others; derivatives are those on ``LINEARISED`` of these.
HARD, RANDOM, LINEARISED = 8, 7, 3
#: Proposals of a step on one machine and on several (with the present individual a power of two),
#: and numbers of these that are evaluated like the result.
PROPOSED, JUDGED = (127, 63), (4, 2)
#: Residuals below a share of the largest one get no larger weight; the share is drawn for each step
#: between these powers of ten, since a polish that is stuck with one may progress with another.
SMALLEST = (-6.0, -2.0)


def check_polish(scenario: Scenario) -> None:
    """Refuse a polish of a controller without continuous coordinates.

    Raises:
        UserError: a polish is requested, and the kind of controller has no coordinates.
    """
    if not scenario.run.polish:
        return
    genome = genome_of(scenario)
    if coordinates(genome, taken(genome.empty(), slice(1))) is None:
        fault = f"a controller of kind {scenario.controller.kind!r} cannot be polished"
        raise UserError(f"run.polish = {scenario.run.polish}: {fault}; leave run.polish at 0")


def polished(
    scenario: Scenario,
    folder: Path,
    begun: tuple[Population, Design, Evaluation],
    made_by: dict[str, str],
    needed: dict[str, str],
    on_step: Callable[[Polished], None],
) -> tuple[Design, Evaluation]:
    """Polish the design ``begun``; if nothing better is found, only a note in its score is new.

    A polish that is stopped and called again ends with the same result as an uninterrupted one.

    Raises:
        RunError: its checkpoint is damaged or was not made with the ``needed`` versions and files,
            or the folder cannot be written.
    """
    individual, design, evaluation = begun
    path, steps = folder / CHECKPOINT, scenario.run.polish
    before = _loaded(path, scenario, needed)
    task = PolishTask(scenario, individual).task
    each = polish(task, individual, steps, scenario.run.seed, before)
    done = stored.checkpointed(each, before, lambda x: checkpoint.save(path, x, made_by), on_step)
    rank, first = float(done.worth[0, 0]), float(done.first[0, 0])
    if rank > first:
        better = design_of(done.population, scenario)
        evaluated = evaluate(better, scenario)
        if scenario.ensemble or evaluated.merit >= evaluation.merit:
            design, evaluation = with_score(better, evaluated, scenario), evaluated
            if scenario.ensemble and rank < 0.0:
                design = noted(design, {LEAST_VIOLATED: True})
    numbers = {"steps": steps, "before": storable(first), "after": storable(rank)}
    return noted(design, {POLISH: numbers}), evaluation


def polish_told(design: Design) -> str:
    """Return a line on the polish of a design; "" if it was not polished or the note is damaged."""
    numbers: Any = design.score.get(POLISH)
    try:
        ends = (numbers["before"], numbers["after"])
        before, after = ("none" if x is None else f"{x:.5g}" for x in ends)
        return f"polish: {numbers['steps']} steps, merit from {before} to {after}"
    except (KeyError, TypeError, ValueError):  # the file has been edited
        return ""


def _loaded(path: Path, scenario: Scenario, needed: dict[str, str]) -> Polished | None:
    """Return the polish stored in a file, as ``stored.read`` does."""
    genome = genome_of(scenario)

    def polished(arrays: archive.Arrays) -> Polished:
        one = taken(genome.empty(), slice(1))
        done: Polished = checkpoint.record_of(Polished, {Population: one}, arrays)
        chart = coordinates(genome, done.about)
        sizes = {len(done.population.tree), len(done.worth), len(done.first)}
        if not (1 <= done.step <= scenario.run.polish and chart and sizes == {1}):
            raise ValueError("its steps are impossible")
        if done.distribution.mean.shape != (chart.size,):
            raise ValueError("its distribution has other parameters")
        return done

    return stored.read(path, 4 * stored.SPARE, needed, polished)


class PolishTask:
    """A scenario as the problem of a polish of ``individual``."""

    def __init__(self, scenario: Scenario, individual: Population):
        self._final = final_problem(scenario)
        self._many = self._final.machines.size > 1
        self._ensemble = self._final.ensemble or Ensemble((1.0,))
        if self._many:
            self._hard = self._final.nearest_to_breaking(individual, HARD)

    @property
    def task(self) -> Polishable:
        """The functions that the polish uses."""
        derived = self.quadratic if self._final.has_derivative else None
        sizes = (PROPOSED[self._many], JUDGED[self._many])
        return Polishable(self._final.genome, self.worth, self.screened, derived, *sizes)

    def worth(self, population: Population) -> Floats:
        """Return ranks (n, 1) on all machines; on a single one (n, 2), also the worst of doubles.

        Only this function defines what a polish has to improve.
        """
        if self._many:  # not ``rank_of_finalists``, where other individuals limit a rank
            return self._final.rank_on(population, np.arange(self._final.machines.size))[:, None]
        rank = self._final.rank_of_finalists(population)
        each = taken(population, np.repeat(np.arange(len(rank)), DOUBLES))
        doubles = self._final.genome.nudged(each, np.random.default_rng(0))
        lowest = self._final.rank_of_finalists(doubles).reshape(-1, DOUBLES).min(axis=1)
        return np.stack([rank, np.minimum(rank, lowest)], axis=1)

    def screened(self, population: Population, rng: np.random.Generator) -> Floats:
        """Return ranks (n,) on some of the machines."""
        return self._final.rank_on(population, self._some(rng))

    def _some(self, rng: np.random.Generator) -> Integers:
        if not self._many:
            return np.zeros(1, int)
        drawn = 1 + rng.permutation(self._final.machines.size - 1)[:RANDOM]
        return np.unique(np.concatenate([[0], self._hard, drawn]))

    def quadratic(self, individual: Population, rng: np.random.Generator) -> Quadratic | None:
        """Return the normal equations, around a population of one, of the cost on a few machines.

        None if a motion or its derivative is not finite, or all weights are zero.
        """
        smallest = 10.0 ** rng.uniform(*SMALLEST)
        machines = np.append(0, rng.permutation(self._some(rng)[1:])[: LINEARISED - 1])
        shares = self._ensemble.shares(self._final.machines.size)
        total: Quadratic | None = None
        for machine, motion in product(machines, range(len(self._final.motions))):
            if not shares[machine, motion]:
                continue
            model = self._of_motion(individual, int(machine), motion, smallest)
            if model is None:
                return None
            share = Quadratic(*(shares[machine, motion] * x for x in model))
            total = share if total is None else Quadratic(*map(np.add, total, share))
        return total

    def _of_motion(
        self, individual: Population, machine: int, motion: int, smallest: float
    ) -> Quadratic | None:
        """Return the normal equations of a motion: residuals weighted by their effect on the cost.

        Steps of encoders and converters are left out: the derivative of a step is 0, so that the
        loop would look open.
        """
        loop, one = self._final.loop.smooth, self._final.machines.take(np.array([machine]))
        samples, gains = self._final.motions[motion], self._final.genome.gains(individual)
        precision = np.float32 if self._many else np.float64
        derivatives = simulate.jacobians(loop, one, samples, gains, RECORDED, precision)
        change = tuple(np.diff(x, axis=0, prepend=0.0 * x[:1]) for x in derivatives["command"])
        residuals = [*derivatives.values(), change]
        merit, slopes = motion_slopes(loop, samples, Traces(*(x for x, _ in residuals)))
        cost = -1.0 if merit <= 0.0 else -1.0 / merit**2
        size = residuals[0][1].shape[1]
        normal, downhill = np.zeros((2, size, size)), np.zeros(size)
        for (value, jacobian), slope in zip(residuals, slopes, strict=True):
            floor = max(smallest * np.abs(value).max(), np.finfo(float).tiny)
            weight = np.maximum(cost * slope * np.sign(value), 0.0)
            weight = weight / np.maximum(np.abs(value), floor)
            if not weight.any():
                continue
            # Weights of a square, and weights that let a residual near 0 change its sign freely.
            bent = weight * value**2 / (value**2 + floor**2)
            ways = [jacobian.T @ (jacobian * one[:, None]) for one in (weight, bent)]
            normal = normal + np.stack(ways)
            downhill = downhill + jacobian.T @ (weight * value)
        finite = np.isfinite(normal).all() and np.isfinite(downhill).all()
        return Quadratic(normal, downhill) if finite and downhill.any() else None
