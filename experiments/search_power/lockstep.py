"""Many seeds of a method side by side: their candidates are scored as one population."""

from collections.abc import Callable, Sequence
from time import perf_counter
from typing import NamedTuple

import numpy as np
from threadpoolctl import threadpool_limits

from experiments.search_power.searches import Asked, Method
from experiments.search_power.tasks import Field, Ledger
from hfc_design.controllers.genome import Population, joined, taken
from hfc_design.core.numbers import Floats

#: The best of a seed that are looked at again in the end.
FINALISTS = 16
#: Shares of the budget at which searches are looked at: of one machine, and of many, sixteen
#: of them in the last half, as many as a design run chooses from.
CHECKS = np.geomspace(0.005, 1.0, 40)
ROBUST_CHECKS = np.append(np.geomspace(0.05, 0.5, 8), np.linspace(0.5, 1.0, 17)[1:])


class Seed(NamedTuple):
    """What one seed of a method did."""

    best: Floats  # (checks,) the best it had been told of; -inf before anything
    seconds: Floats  # (checks,) of its own
    #: What it would have given at each check; at the end with the best that it was told of.
    incumbents: list[Population]
    spent: int  # samples


class Running:
    """One seed."""

    def __init__(self, method: Method, field: Field, seed: int):
        self.field, self.ledger = field, Ledger()
        self.search = method(field, self.ledger, seed)
        self.checks = CHECKS if field.single else ROBUST_CHECKS
        self.incumbents: list[Population] = []
        self.kept: Population | None = None
        self.worth = np.empty(0)
        self.asked: Asked | None = next(self.search)

    def told(self, score: Floats, samples: float, clock: Callable[[], float]) -> None:
        """Go on; a round that would end beyond the budget is not counted."""
        assert self.asked is not None
        ledger, budget = self.ledger, self.field.budget
        self._looked()
        if ledger.samples + samples > budget:
            return self._stop()
        ledger.spend(samples)
        ledger.see(float(score.max(initial=-np.inf)))
        ledger.times.append((ledger.samples, clock()))
        self._keep(self.asked.population, score)
        try:
            self.asked = self.search.send(score)
        except StopIteration:
            self._stop()
        return None

    def _stop(self) -> None:
        self.search.close()
        self.ledger.samples = self.field.budget
        self._looked()
        self.asked = None

    def _keep(self, population: Population, score: Floats) -> None:
        least = self.worth[-1] if len(self.worth) == FINALISTS else -np.inf
        better = np.flatnonzero(score > least)
        if not len(better):
            return
        own, worth = taken(population, better), score[better]
        if self.kept is not None:
            own, worth = joined(self.kept, own), np.append(self.worth, worth)
        order = np.unique(-worth, return_index=True)[1][:FINALISTS]  # doubles only once
        self.kept, self.worth = taken(own, order), worth[order]

    def _looked(self) -> None:
        """Note what it would give, at every check that is reached."""
        share = self.ledger.samples / self.field.budget
        while len(self.incumbents) < len(self.checks) and (
            share >= self.checks[len(self.incumbents)] - 1e-12
        ):
            now = self.asked.incumbent if self.asked is not None else None
            if now is None:
                now = self.kept
            if now is None:
                assert self.asked is not None
                now = taken(self.asked.population, slice(1))
            self.incumbents.append(now)

    def result(self) -> Seed:
        """Once it has ended."""
        at = self.checks * self.field.budget
        steps = np.array([(0, -np.inf), *self.ledger.steps], float)
        best = steps[np.searchsorted(steps[:, 0], at, side="right") - 1, 1]
        times = np.array([(0, 0.0), *self.ledger.times], float)
        seconds = np.interp(at, *times.T)
        last = [self.incumbents[-1]] + ([self.kept] if self.kept is not None else [])
        return Seed(best, seconds, [*self.incumbents[:-1], joined(*last)], int(times[-1, 0]))


def together(
    method: Method,
    field: Field,
    seeds: Sequence[int],
    told: Callable[[float], None] = lambda share: None,
) -> list[Seed]:
    """All seeds to the end of their budgets; ``told`` is the share of these that is spent."""
    with threadpool_limits(1, user_api="blas"):  # small matrices lose by a second thread
        return _together(method, field, seeds, told)


def _together(
    method: Method, field: Field, seeds: Sequence[int], told: Callable[[float], None]
) -> list[Seed]:
    begun, lost = perf_counter(), field.lost

    def clock() -> float:
        return (perf_counter() - begun - (field.lost - lost)) / len(seeds)

    running = [Running(method, field, seed) for seed in seeds]
    while alive := [k for k, one in enumerate(running) if one.asked is not None]:
        each = [running[k].asked for k in alive]
        asked = [one for one in each if one is not None]
        if any(one.hard is not None for one in asked):  # each on machines of its own
            found = [field.scored(x.population, x.when, hard=x.hard) for x in asked]
        else:
            found = _at_once(field, asked)
        for k, (own, cost) in zip(alive, found, strict=True):
            running[k].told(own, float(cost.sum()), clock)
        told(float(np.mean([one.ledger.samples for one in running]) / field.budget))
    return [one.result() for one in running]


def _at_once(field: Field, asked: Sequence[Asked]) -> list[tuple[Floats, Floats]]:
    """Of each its scores and what they cost; all candidates are one population."""
    needed = [
        np.full(len(one.population.tree), -np.inf) if one.needed is None else one.needed
        for one in asked
    ]
    ends = np.cumsum([len(one.population.tree) for one in asked])[:-1]
    population = joined(*(one.population for one in asked))
    score, samples = field.scored(population, asked[0].when, np.concatenate(needed))
    return list(zip(np.split(score, ends), np.split(samples, ends), strict=True))
