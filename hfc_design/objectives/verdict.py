"""Many motions of many machines -> one number a design: what it is ranked by.

Motions are averaged as one long motion would be: a merit is the inverse of a cost, and costs add
up. Of the machines the worst, a lower quantile or the mean is kept. A design that breaks a
constraint anywhere ranks below every one that breaks none, and the more it breaks, the lower
(Deb 2000, feasible ones first), so that no merit buys it off.
"""

from typing import Literal, NamedTuple

import numpy as np

from hfc_design.core.numbers import Floats, Mask
from hfc_design.objectives.constraints import Constraint
from hfc_design.objectives.judge import Judged

Keep = Literal["worst", "quantile", "mean"]


class Verdict(NamedTuple):
    """Of designs: what they are ranked by, and of each machine what it says."""

    rank: Floats  # (designs,) the merit; negative where a constraint is broken, -inf: all failed
    merit: Floats  # (designs, machines) of all motions together; 0 where one failed
    broken: Floats  # (designs, machines, motions, 1 + constraints) by how much, 0 to 1

    @property
    def sound(self) -> Mask:
        """(designs, machines) whether a machine keeps everything in every motion."""
        return np.asarray(~(self.broken > 0.0).any(axis=(2, 3)))


class Ensemble(NamedTuple):
    """How the many become one."""

    weights: tuple[float, ...]  # of the motions
    constraints: tuple[Constraint, ...] = ()
    keep: Keep = "mean"
    quantile: float = 0.1

    def verdict(self, judged: Judged) -> Verdict:
        """Of ``judged`` (designs, machines, motions); constraints are its last values."""
        weights = np.array(self.weights) / sum(self.weights)
        with np.errstate(all="ignore"):
            costs = np.where(judged.failed | ~(judged.merit > 0.0), np.inf, 1.0 / judged.merit)
            merit = 1.0 / (costs @ weights)
        broken = self._broken(judged)
        violation = broken.mean(axis=(1, 2)).sum(axis=-1)
        kept = self._kept(merit)
        rank = np.where(violation > 0.0, -violation, kept)
        lost = judged.failed.all(axis=(1, 2))
        return Verdict(np.where(lost, -np.inf, rank), merit, broken)

    def costs(self, values: Floats) -> Floats:
        """(designs, measures) of ``values`` (designs, machines, motions, measures).

        As merits become one: means of the motions, and of the machines what is kept.
        """
        weights = np.array(self.weights) / sum(self.weights)
        with np.errstate(all="ignore"):
            each = np.einsum("dmtk,t->dmk", values, weights)
            ways = {
                "worst": lambda: each.max(axis=1),
                "quantile": lambda: np.quantile(each, 1 - self.quantile, axis=1, method="higher"),
                "mean": lambda: each.mean(axis=1),
            }
            return np.asarray(ways[self.keep]())

    def _broken(self, judged: Judged) -> Floats:
        failed = judged.failed[..., None].astype(float)
        values = judged.values[..., judged.values.shape[-1] - len(self.constraints) :]
        most = np.array([one.most for one in self.constraints])
        scale = np.where(most > 0.0, most, 1.0)
        over = np.nan_to_num(np.maximum(values - most, 0.0) / scale, nan=np.inf)
        # More is always worse, but of what runs away only that it does counts, not how fast.
        over = 1.0 - 1.0 / (1.0 + over)
        return np.concatenate([failed, np.where(failed, 1.0, over)], axis=-1)

    def _kept(self, merit: Floats) -> Floats:
        """(designs,) one merit of all machines."""
        with np.errstate(all="ignore"):
            ways = {
                "worst": lambda: merit.min(axis=1),
                "quantile": lambda: np.quantile(merit, self.quantile, axis=1, method="lower"),
                "mean": lambda: 1.0 / (1.0 / merit).mean(axis=1),
            }
            return np.asarray(ways[self.keep]())
