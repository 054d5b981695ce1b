"""Test functions of two objectives whose fronts are known, and a genome of plain numbers.

Zitzler, Deb and Thiele, Evolutionary Computation 8(2), 2000. Crossover and mutation are those of
Deb and Agrawal (simulated binary, 1995) and Deb (polynomial, 2001), as pymoo has them.
"""

from typing import NamedTuple

import numpy as np

from hfc_design.controllers.genome import Genome
from hfc_design.search.strategy import Scored

SIZE = 30


class Points(NamedTuple):
    tree: np.ndarray
    x: np.ndarray  # (n, SIZE)


class PointGenome(Genome):
    structures = 1

    def __init__(self, seed=0):
        self.rng = np.random.default_rng(seed)

    def empty(self):
        return Points(np.zeros(1, int), np.full((1, SIZE), 0.5))

    def fresh(self, tree, rng):
        return Points(np.zeros(len(tree), int), rng.random((len(tree), SIZE)))

    def blended(self, one, other, share, eta=15.0):
        u = self.rng.random(one.x.shape)
        spread = np.where(u <= 0.5, 2 * u, 1 / (2 * (1 - u))) ** (1 / (eta + 1))
        crossed = self.rng.random(one.x.shape) < 0.5
        first = self.rng.random(one.x.shape) < 0.5
        middle, half = (one.x + other.x) / 2, np.abs(other.x - one.x) / 2
        moved = middle + np.where(first, 1, -1) * spread * half
        x = np.where(crossed, moved, one.x)
        return one._replace(x=np.where((share == 0.0)[:, None], one.x, np.clip(x, 0, 1)))

    def mutated(self, population, step, rng, eta=20.0):
        x, u = population.x, rng.random(population.x.shape)
        low = (2 * u + (1 - 2 * u) * (1 - x) ** (eta + 1)) ** (1 / (eta + 1)) - 1
        high = 1 - (2 * (1 - u) + 2 * (u - 0.5) * x ** (eta + 1)) ** (1 / (eta + 1))
        moved = np.clip(x + np.where(u < 0.5, low, high), 0, 1)
        return population._replace(x=np.where(rng.random(x.shape) < 1 / SIZE, moved, x))


def zdt(number, x):
    """(n, 2) costs of (n, SIZE) numbers in [0, 1]."""
    first, g = x[:, 0], 1 + 9 * x[:, 1:].mean(axis=1)
    share = first / g
    return np.stack([first, g * (1 - (np.sqrt(share) if number == 1 else share**2))], axis=1)


def scored(costs):
    """That nothing fails or is forbidden; ranked by the sum of the costs."""
    return Scored(-costs.sum(axis=1), costs, np.zeros(len(costs)))
