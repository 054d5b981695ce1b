"""Reduction of many motions of many machines to one number for each design, which ranks it.

Motions are averaged like one long motion: a merit is the inverse of a cost, and costs add up. Over
the machines, the worst, a lower quantile or the mean is taken. A design that breaks a constraint
ranks below every design that breaks none; the larger the violation, the lower the rank, whatever
the merit (Deb 2000). With very many machines some may break constraints (they are forgiven), as in
a chance constraint, but never the nominal machine.
"""

from typing import Literal, NamedTuple

import numpy as np

from hfc_design.core.numbers import SAME, SAME_SINGLE, Floats, Integers, Mask, floored
from hfc_design.objectives.constraints import Constraint
from hfc_design.objectives.judge import Judged

Keep = Literal["worst", "quantile", "mean"]


#: Largest cost of a machine where constraints are weighed, as a multiple of the median cost.
WORST = 20.0


class Verdict(NamedTuple):
    """Ranks of designs, and the results of each machine."""

    rank: Floats  # (designs,) merit, or minus the violation if there is one; -inf: all failed
    weighed: Floats  # (designs,) the same with violations weighed by a penalty; without one, rank
    merit: Floats  # (designs, machines) of all motions together; 0 where a motion failed
    broken: Floats  # (designs, machines, motions, failure + constraints) violations, 0 to 1

    @property
    def sound(self) -> Mask:
        """Mask (designs, machines): the machine passes every motion."""
        return np.asarray(~(self.broken > 0.0).any(axis=(2, 3)))


class Ensemble(NamedTuple):
    """Rules for the reduction of motions and machines to one number."""

    weights: tuple[float, ...]  # of the motions
    constraints: tuple[Constraint, ...] = ()
    keep: Keep = "mean"
    quantile: float = 0.1
    forgiven: float = 0.0  # share of the machines that need not keep the constraints
    nominal: tuple[bool, ...] = ()  # for each motion, whether it counts on the nominal machine only

    def verdict(
        self, judged: Judged, penalty: float | None = None, more_violation: Floats | float = 0.0
    ) -> Verdict:
        """Return the verdict on ``judged``, whose arrays begin with (designs, machines, motions).

        The last of ``judged.values`` belong to the constraints. ``more_violation`` (designs,) is
        added to the violation of each design. With a ``penalty``, the merit and the violation are
        also weighed against each other (``_weighed``).
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
        """Return the highest rank (designs,) that each can still reach on ``machines`` machines.

        ``judged`` has the results on the first machines. At best, the other machines have no cost
        and no violation, and the forgiven machines are the worst of the first.
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
        """Return the rules with limits divided by ``factor``, as few machines stand for many."""
        less = [one._replace(most=one.most / factor) for one in self.constraints]
        return self._replace(constraints=tuple(less))

    def costs(self, values: Floats) -> Floats:
        """Return costs (designs, metrics) from ``values`` (designs, machines, motions, metrics).

        They are reduced as merits are: mean over the motions, then the rule ``keep`` over the
        machines.
        """
        weights = self.shares(values.shape[1])[..., None]
        low = self.quantile * (1.0 + SAME)  # so that rounding does not select a neighbour
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
        """Mask (motions,): the motion counts on the nominal machine only."""
        return np.array(self.nominal or [False] * len(self.weights))

    def shares(self, machines: int) -> Floats:
        """Return weights (machines, motions), with sum 1 per machine; the nominal one is first."""
        counts = np.tile(self.weights, (machines, 1))
        counts[1:, self._nominal] = 0.0
        return np.asarray(counts / counts.sum(axis=1, keepdims=True))

    def _required(self, violation: Floats) -> Integers:
        """Return indices (designs, required) of machines that must pass: the nominal, the best."""
        others = violation.shape[1] - 1
        order = np.argsort(violation[:, 1:], axis=1, kind="stable") + 1
        order = np.sort(order[:, : others - floored(self.forgiven * others)], axis=1)
        return np.concatenate([np.zeros_like(order, shape=(len(order), 1)), order], axis=1)

    def _violation(self, broken: Floats, machines: int) -> Floats:
        """Return violations (designs, first machines): mean over the motions of summed ``broken``.

        A motion that counts on the nominal machine only is multiplied by the number ``machines``.
        """
        often = np.where(self._nominal, machines, 1)
        return np.asarray((often * broken.sum(axis=-1)).mean(axis=2))

    def _weighed(self, merit: Floats, violation: Floats, penalty: float) -> Floats:
        """Return the merits (designs,), reduced the more the larger the violation (designs,).

        The penalty grows during a search (as in Joines and Houck, CEC 1994). Here it divides
        merits, so that it has no unit: a violation of 1 / ``penalty`` divides a merit by e. A
        machine costs at most ``WORST`` times the median. If half of the machines fail, or the
        result is rounded to 0, the result is minus the violation.
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
        # 0.1 in float32 is more than 0.1, but a value that is just at this limit is allowed.
        over = np.where(values <= most * (1.0 + SAME_SINGLE), 0.0, values - most)
        over = np.nan_to_num(over / scale, nan=np.inf)
        # A larger excess is always worse, but at most 1, however large it is.
        over = 1.0 - 1.0 / (1.0 + over)
        return np.concatenate([failed, np.where(failed, 1.0, over)], axis=-1)

    def _overall(self, merit: Floats) -> Floats:
        """Return one merit (designs,) from the merits (designs, machines)."""
        low = self.quantile * (1.0 + SAME)
        with np.errstate(all="ignore"):
            ways = {
                "worst": lambda: merit.min(axis=1),
                "quantile": lambda: np.quantile(merit, low, axis=1, method="lower"),
                "mean": lambda: 1.0 / (1.0 / merit).mean(axis=1),
            }
            return np.asarray(ways[self.keep]())
