"""CMA-ES with several small distributions at once, each restarted when it has converged.

It suits few numbers and many local optima (Auger and Hansen, CEC 2005). The distributions, called
islands, begin at the best of many first points; their samples are scored as one population.
"""

from collections.abc import Callable
from itertools import count
from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import Floats
from hfc_design.search.distribution import Distribution, begun, drawn, learnt

#: Largest and smallest number of islands, and points of each island in a round.
ISLANDS, LEAST, SAMPLES = 8, 2, 16
#: Number of rounds that the remaining evaluations should allow for each island. It determines the
#: number of islands, which decreases: in the end only the best islands continue.
ROUNDS = 60
#: First standard deviation of an island, and of the mean of a restarted one around the best point.
STEP, ANEW = 0.4, 1.0
#: An island whose best score has not risen by this share within so many rounds is restarted.
GAIN, PATIENCE = 1e-3, 12


class Tried(NamedTuple):
    """All points that were scored."""

    points: Floats  # (n, size)
    score: Floats  # (n,) -inf where a point failed


def multistart(
    first: Floats, evaluate: Callable[[Floats], Floats], evaluations: int, rng: np.random.Generator
) -> Tried:
    """Search with up to ``evaluations`` points, ``first`` (n, size) included; return all of them.

    ``evaluate`` returns the scores (n,) of points (n, size), -inf for a point that failed.
    """
    tried = Tried(first, evaluate(first))
    order = np.argsort(-tried.score, kind="stable")
    waiting = [first[k] for k in order if np.isfinite(tried.score[k])]
    some = room(evaluations - len(first))
    islands = [Island(begun(point, STEP), 0) for point in waiting[:some]]
    waiting = waiting[some:]
    for number in count():
        left = evaluations - len(tried.score)
        islands = sorted(islands, key=lambda one: -one.best)[: room(left)]
        if not islands or left < len(islands) * SAMPLES:
            break
        points = np.stack([drawn(one.distribution, SAMPLES, rng) for one in islands])
        scores = evaluate(points.reshape(-1, points.shape[-1])).reshape(points.shape[:2])
        each = zip(tried, (points, scores), strict=True)
        tried = Tried(*(np.concatenate([before, *more]) for before, more in each))
        for k, one in enumerate(islands):
            learning = learnt(one.distribution, points[k], scores[k])
            islands[k] = one.after(learning, float(scores[k].max()), number)
            if number - islands[k].gained < PATIENCE:
                continue
            about = tried.points[int(np.argmax(tried.score))]
            anew = about + ANEW * rng.standard_normal(len(about))
            other = waiting.pop(0) if waiting and rng.random() < 0.5 else anew
            islands[k] = Island(begun(other, STEP), number)
    return tried


def room(evaluations: int, rounds: int = ROUNDS, least: int = LEAST) -> int:
    """Return the number of islands, ``least`` or more, for which the evaluations are enough."""
    return int(np.clip(evaluations // (rounds * SAMPLES), least, ISLANDS))


class Island(NamedTuple):
    """A distribution, and the round of its last notable improvement."""

    distribution: Distribution
    gained: int  # number of this round
    best: float = -np.inf

    def after(self, distribution: Distribution, best: float, number: int) -> "Island":
        """Return the island after round ``number``, in which its best sample scored ``best``."""
        if best > self.best + GAIN * abs(self.best) or not np.isfinite(self.best):
            return Island(distribution, number, best)
        return self._replace(distribution=distribution)
