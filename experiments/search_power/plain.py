"""L-SHADE as a peer, and the steps of the paper's genetic algorithm."""

import numpy as np

from experiments.search_power.charts import Chart
from hfc_design.core.numbers import Floats
from hfc_design.search.differential import Trials, begun, learnt, tried

#: Candidates of L-SHADE in the end.
LAST = 4


class LShade:
    """L-SHADE as ``search.differential`` has it, from a cloud of size ``step`` about 0 on.

    The population shrinks linearly with the ``share`` of its time that has passed, which its
    owner sets.
    """

    def __init__(self, chart: Chart, step: float, samples: int, seed: int):
        self.rng = np.random.default_rng(seed)
        self.room, self.first, self.share = (chart.low, chart.high), samples, 0.0
        cloud = step * self.rng.standard_normal((samples, chart.size))
        cloud[0] = 0.0
        self.points = begun(np.clip(cloud, *self.room))
        self.costs: Floats | None = None
        self.trials: Trials | None = None

    def ask(self) -> Floats:
        """The first population, then trials."""
        if self.costs is None:
            return self.points.places
        self.trials = tried(self.points, -self.costs, self.room, self.rng)
        return self.trials.places

    def tell(self, points: Floats, costs: Floats) -> None:
        """Whoever is no better than its trial gives way, and the best of them remain."""
        if self.costs is None or self.trials is None:
            self.costs = costs
            return
        self.points = learnt(self.points, self.trials, self.costs - costs)
        self.costs = np.minimum(self.costs, costs)
        size = max(round(self.first + (LAST - self.first) * min(self.share, 1.0)), LAST)
        best = np.sort(np.argsort(self.costs, kind="stable")[:size])
        places, self.costs = self.points.places[best], self.costs[best]
        self.points = self.points._replace(places=places)

    done, incumbent = False, None


class Thirds:
    """The second phase of Lin & Lee's genetic algorithm on points (1999, section 3.2).

    A third is the elite, a third weighted averages of pairs, a third moves every number with
    probability 0.8 by up to ``step`` either way. For controllers to which the paper's own
    structures do not apply.
    """

    def __init__(self, chart: Chart, step: float, samples: int, seed: int):
        self.rng = np.random.default_rng(seed)
        self.chart, self.step = chart, step
        cloud = step * self.rng.standard_normal((samples, chart.size))
        cloud[0] = 0.0
        self.points = np.clip(cloud, chart.low, chart.high)

    def ask(self) -> Floats:
        """The next generation."""
        return self.points

    def tell(self, points: Floats, costs: Floats) -> None:
        """Elite, crossed and moved thirds."""
        rng, count = self.rng, len(points)
        third = max(count // 3, 1)
        elite = points[np.argsort(costs, kind="stable")[:third]]
        one, other = rng.integers(count, size=(2, third))
        share = rng.random((third, 1))
        crossed = share * points[one] + (1.0 - share) * points[other]
        moved = points[rng.choice(count, count - 2 * third, replace=False)]
        change = rng.uniform(-self.step, self.step, moved.shape)
        moved = moved + change * (rng.random(moved.shape) < 0.8)
        both = np.concatenate([elite, crossed, moved])
        self.points = np.clip(both, self.chart.low, self.chart.high)

    done, incumbent = False, None
