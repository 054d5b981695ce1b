"""Other people's optimizers, all alike: points are asked for, and told what they cost.

Each begins at 0 with a first standard deviation ``step`` of every coordinate, or with a cloud of
that size, and minimises. They come from the extra ``peers``, which nothing else here needs.
"""

import warnings
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple, Protocol

import numpy as np

from experiments.search_power.charts import Chart
from hfc_design.core.numbers import Floats

#: What a candidate costs that failed: more than any other.
FAILED = 1e9


class Optimizer(Protocol):
    """One search of one chart."""

    def ask(self) -> Floats:
        """(n, size) points to look at."""

    def tell(self, points: Floats, costs: Floats) -> None:
        """What they cost (n,)."""

    @property
    def done(self) -> bool:
        """Whether it has come to rest."""

    @property
    def incumbent(self) -> Floats | None:
        """(size,) what it would give now; None: the best that it has seen."""


#: Of a chart, a first standard deviation, candidates of a round and a seed.
Make = Callable[[Chart, float, int, int], Optimizer]


class Cma:
    """CMA-ES of the package ``cma`` (Hansen), with its own ways to come to rest."""

    def __init__(
        self,
        chart: Chart,
        step: float,
        samples: int,
        seed: int,
        diagonal: bool = False,
        penalty: bool = False,
    ):
        import cma

        rng = np.random.default_rng(seed)
        options = {
            "randn": lambda *shape: rng.standard_normal(shape),  # else NumPy's global numbers
            "CMA_diagonal": diagonal,
            "popsize": samples,
            "seed": float("nan"),
            "verbose": -9,
            "verb_log": 0,
            "verb_disp": 0,
            "tolstagnation": 0 if diagonal else None,
            "bounds": [chart.low.tolist(), chart.high.tolist()] if penalty else None,
            "BoundaryHandler": cma.BoundPenalty if penalty else None,
        }
        options = {key: value for key, value in options.items() if value is not None}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            self._es = cma.CMAEvolutionStrategy(np.zeros(chart.size), step, options)

    def ask(self) -> Floats:
        """Samples of the distribution."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return np.array(self._es.ask())

    def tell(self, points: Floats, costs: Floats) -> None:
        """Learn from them."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            self._es.tell(list(points), costs.tolist())

    @property
    def done(self) -> bool:
        """By the criteria of the package."""
        return bool(self._es.stop())

    @property
    def incumbent(self) -> Floats | None:
        """The mean, within the bounds."""
        return np.asarray(self._es.result.xfavorite)


class PymooGa:
    """The genetic algorithm of pymoo: tournaments, SBX, polynomial mutation, the best survive."""

    def __init__(self, chart: Chart, step: float, samples: int, seed: int):
        from pymoo.algorithms.soo.nonconvex.ga import GA
        from pymoo.core.problem import Problem
        from pymoo.operators.crossover.sbx import SBX
        from pymoo.operators.mutation.pm import PM

        rng = np.random.default_rng(seed)
        cloud = step * rng.standard_normal((samples, chart.size))
        cloud[0] = 0.0
        low, high = (np.clip(end, -REACH * step, REACH * step) for end in (chart.low, chart.high))
        high = np.maximum(high, low + 1e-9)
        self._problem = Problem(n_var=chart.size, n_obj=1, xl=low, xu=high)
        self._ga = GA(
            pop_size=samples,
            sampling=np.clip(cloud, low, high),
            crossover=SBX(prob=0.9, eta=10),
            mutation=PM(eta=20),
        )
        self._ga.setup(self._problem, seed=seed, verbose=False)

    def ask(self) -> Floats:
        """Offspring; fewer where it makes doubles."""
        self._asked = self._ga.ask()
        return np.array(self._asked.get("X"), float)

    def tell(self, points: Floats, costs: Floats) -> None:
        """Survival."""
        self._asked.set("F", costs[:, None], "G", np.zeros((len(costs), 0)))
        for one in self._asked:
            one.evaluated.update({"F", "G", "H"})
        self._ga.tell(infills=self._asked)

    done, incumbent = False, None


#: The box of the genetic algorithm, in first standard deviations.
REACH = 10.0


class _Evosax(NamedTuple):
    strategy: Any
    params: Any
    populates: bool


@cache
def _evosax(name: str, samples: int, size: int) -> _Evosax:
    """One for all seeds: it is compiled once."""
    from evosax import algorithms

    solution = np.zeros(size, np.float32)
    strategy = getattr(algorithms, name)(population_size=samples, solution=solution)
    return _Evosax(strategy, strategy.default_params, hasattr(strategy, "get_population"))


class Evosax:
    """An algorithm of evosax by its name, in units of the first standard deviation."""

    def __init__(self, chart: Chart, step: float, samples: int, seed: int, name: str = "SNES"):
        import jax

        self._own, self._step, self._chart = _evosax(name, samples, chart.size), step, chart
        self._key = jax.random.key(seed)
        self._state: Any = None
        self._first = None
        self._asked: Any = None
        if self._own.populates:
            rng = np.random.default_rng(seed)
            self._first = rng.standard_normal((samples, chart.size)).astype(np.float32)
            self._first[0] = 0.0
        else:
            start = np.zeros(chart.size, np.float32)
            with jax.enable_x64(False):
                self._state = self._own.strategy.init(self._next(), start, self._own.params)

    def _next(self) -> Any:
        import jax

        self._key, key = jax.random.split(self._key)
        return key

    def ask(self) -> Floats:
        """Candidates within the chart."""
        import jax

        if self._state is None:
            self._asked = self._first
        else:
            with jax.enable_x64(False):  # it counts in float32
                own = (self._next(), self._state, self._own.params)
                self._asked, self._state = self._own.strategy.ask(*own)
        points = self._step * np.asarray(self._asked, np.float64)
        return np.clip(np.nan_to_num(points), self._chart.low, self._chart.high)

    def tell(self, points: Floats, costs: Floats) -> None:
        """Learn from them."""
        import jax

        told = costs.astype(np.float32)
        with jax.enable_x64(False):
            if self._state is None:
                first = (self._next(), self._asked, told, self._own.params)
                self._state = self._own.strategy.init(*first)
                return
            own = (self._next(), self._asked, told, self._state, self._own.params)
            self._state, _ = self._own.strategy.tell(*own)

    done = False

    @property
    def incumbent(self) -> Floats | None:
        """The mean, where it has one."""
        if self._own.populates:
            return None
        mean = self._step * np.asarray(self._own.strategy.get_mean(self._state), np.float64)
        return np.clip(np.nan_to_num(mean), self._chart.low, self._chart.high)
