"""Reduction of many motions of many machines to one number for each design, which ranks it.

Motions are averaged like one long motion: a merit is the inverse of a cost, and costs add up. Over
the machines, the worst, a lower quantile or the mean is taken. A design that breaks a constraint
ranks below every one that breaks none, and the more it breaks, the lower (Deb 2000, feasible ones
first), so that no merit compensates it. With very many machines some may be forgiven, as in a
chance constraint, but never the nominal one.
"""

from typing import Literal, NamedTuple

import numpy as np

from hfc_design.core.numbers import SAME, SAME_SINGLE, Floats, Integers, Mask, floored
from hfc_design.objectives.constraints import Constraint
from hfc_design.objectives.judge import Judged

Keep = Literal["worst", "quantile", "mean"]


#: What a machine costs at most where constraints are weighed, in medians of all machines.
WORST = 20.0


class Verdict(NamedTuple):
    """Ranks of designs, and the results of each machine."""

    rank: Floats  # (designs,) the merit; negative where a constraint is broken, -inf: all failed
    weighed: Floats  # (designs,) the same with constraints weighed by a penalty; without one, rank
    merit: Floats  # (designs, machines) of all motions together; 0 where one failed
    broken: Floats  # (designs, machines, motions, 1 + constraints) by how much, 0 to 1

    @property
    def sound(self) -> Mask:
        """(designs, machines) whether a machine passes every motion."""
        return np.asarray(~(self.broken > 0.0).any(axis=(2, 3)))


class Ensemble(NamedTuple):
    """Rules for the reduction to one number."""

    weights: tuple[float, ...]  # of the motions
    constraints: tuple[Constraint, ...] = ()
    keep: Keep = "mean"
    quantile: float = 0.1
    forgiven: float = 0.0  # share of the machines that need not keep the constraints
    nominal: tuple[bool, ...] = ()  # of the motions, which count on the nominal machine alone

    def verdict(
        self, judged: Judged, penalty: float | None = None, more_violation: Floats | float = 0.0
    ) -> Verdict:
        """Verdict on ``judged`` (designs, machines, motions); constraints are its last values.

        ``more_violation`` (designs,) is added to the violation of each design and lowers its rank.

        With a ``penalty`` merit and constraints are also weighed against each other: ``_weighed``.
        """
        weights = self.shares(judged.failed.shape[1])
        with np.errstate(all="ignore"):
            costs = np.where(judged.failed | ~(judged.merit > 0.0), np.inf, 1.0 / judged.merit)
            merit = 1.0 / np.where(weights > 0.0, weights * costs, 0.0).sum(axis=-1)
        broken = np.where(weights[..., None] > 0.0, self._broken(judged), 0.0)
        violation = self._violation(broken, len(weights))
        required = self._required(violation)
        violation, some = (np.take_along_axis(x, required, axis=1) for x in (violation, merit))
        most = violation.mean(axis=1) + more_violation
        rank = np.where(most > 0.0, -most, self._overall(some))
        weighed = rank if penalty is None else self._weighed(some, most, penalty)
        lost = (judged.failed | (weights == 0.0)).all(axis=(1, 2))
        rank, weighed = (np.where(lost, -np.inf, x) for x in (rank, weighed))
        return Verdict(rank, weighed, merit, broken)

    def best_rank(
        self, judged: Judged, machines: int, more_violation: Floats | float = 0.0
    ) -> Floats:
        """(designs,) highest rank that each can still reach, with ``machines`` in all.

        ``judged`` are the first of them. The others may have no cost and no violation, and the
        forgiven ones may be the worst of the first.
        """
        verdict, forgiven = self.verdict(judged), floored(self.forgiven * (machines - 1))
        required, left = machines - forgiven, max(judged.failed.shape[1] - 1 - forgiven, 0)
        violation = self._violation(verdict.broken, machines)
        least = violation[:, 0] + np.sort(violation[:, 1:], axis=1)[:, :left].sum(axis=1)
        best = np.sort(verdict.merit[:, 1:], axis=1)[:, ::-1][:, :left]
        free = np.full((len(best), required - 1 - left), np.inf)
        merit = self._overall(np.concatenate([verdict.merit[:, :1], best, free], axis=1))
        least = least / required + more_violation
        return np.where(least > 0.0, -least, merit)

    def tighter(self, factor: float) -> "Ensemble":
        """The same rules with constraints tighter by a ``factor``: few machines stand for many."""
        less = [one._replace(most=one.most / factor) for one in self.constraints]
        return self._replace(constraints=tuple(less))

    def costs(self, values: Floats) -> Floats:
        """(designs, metrics) reduced from ``values`` (designs, machines, motions, metrics).

        The reduction is that of merits: mean over the motions, then the chosen rule over the
        machines.
        """
        weights = self.shares(values.shape[1])[..., None]
        low = self.quantile * (1.0 + SAME)  # to be among (n - 1) others, but for rounding
        with np.errstate(all="ignore"):
            each = np.where(weights > 0.0, weights * values, 0.0).sum(axis=2)
            ways = {
                "worst": lambda: each.max(axis=1),
                "quantile": lambda: np.quantile(each, 1 - low, axis=1, method="higher"),
                "mean": lambda: each.mean(axis=1),
            }
            return np.asarray(ways[self.keep]())

    @property
    def _nominal(self) -> Mask:
        """(motions,)."""
        return np.array(self.nominal or [False] * len(self.weights))

    def shares(self, machines: int) -> Floats:
        """(machines, motions) weights with the sum 1 in every machine; the nominal one is first."""
        counts = np.tile(self.weights, (machines, 1))
        counts[1:, self._nominal] = 0.0
        return np.asarray(counts / counts.sum(axis=1, keepdims=True))

    def _required(self, violation: Floats) -> Integers:
        """(designs, some) machines that have to pass, the nominal one always."""
        others = violation.shape[1] - 1
        order = np.argsort(violation[:, 1:], axis=1, kind="stable") + 1
        order = np.sort(order[:, : others - floored(self.forgiven * others)], axis=1)
        return np.concatenate([np.zeros_like(order, shape=(len(order), 1)), order], axis=1)

    def _violation(self, broken: Floats, machines: int) -> Floats:
        """(designs, machines) sum of violations (``broken``) on the first of so many ``machines``.

        A requirement on one machine only counts as if it were required of all of them.
        """
        often = np.where(self._nominal, machines, 1)
        return np.asarray((often * broken.sum(axis=-1)).mean(axis=2))

    def _weighed(self, merit: Floats, violation: Floats, penalty: float) -> Floats:
        """(designs,) the merit that is kept, the less the larger the violation (designs,).

        A penalty that grows on the way (Joines and Houck, CEC 1994) here multiplies costs, so that
        it has no unit: 1 / ``penalty`` of violation is worth a factor e. A machine that fails costs
        ``WORST`` times the median of them; where half of them fail, or too little is left for a
        number, the violation ranks alone.
        """
        median = np.median(merit, axis=1)
        overall = self._overall(np.maximum(merit, median[:, None] / WORST))
        weighed = overall * np.exp(-penalty * violation)
        return np.where((median > 0.0) & (weighed > 0.0), weighed, -violation)

    def _broken(self, judged: Judged) -> Floats:
        failed = judged.failed[..., None].astype(float)
        values = judged.values[..., judged.values.shape[-1] - len(self.constraints) :]
        most = np.array([one.most for one in self.constraints])
        scale = np.where(most > 0.0, most, 1.0)
        # 0.1 in float32 is more than 0.1, and a drive that stands at such a limit keeps to it.
        over = np.where(values <= most * (1.0 + SAME_SINGLE), 0.0, values - most)
        over = np.nan_to_num(over / scale, nan=np.inf)
        # More is always worse, but of what runs away only that it does counts, not how fast.
        over = 1.0 - 1.0 / (1.0 + over)
        return np.concatenate([failed, np.where(failed, 1.0, over)], axis=-1)

    def _overall(self, merit: Floats) -> Floats:
        """(designs,) one merit of all machines."""
        low = self.quantile * (1.0 + SAME)
        with np.errstate(all="ignore"):
            ways = {
                "worst": lambda: merit.min(axis=1),
                "quantile": lambda: np.quantile(merit, low, axis=1, method="lower"),
                "mean": lambda: 1.0 / (1.0 / merit).mean(axis=1),
            }
            return np.asarray(ways[self.keep]())
