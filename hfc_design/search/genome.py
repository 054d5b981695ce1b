"""What a search varies: the structure, the consequents, the scales and the PD gains."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hfc_design import hierarchy
from hfc_design.controllers import HierarchicalGains

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Mask = NDArray[np.bool_]


class Population(NamedTuple):
    """n individuals; every array carries them in its leading axis."""

    tree: Integers  # (n,) index into ``hierarchy.trees(inputs)``
    gains: Floats  # (n, 2): kp [V/rad], kd [V s/rad]
    scales: Floats  # (n, inputs): k_1, k_2, ..., per unit of the input
    consequents: Floats  # (n, units, 7, 7), [unit][row term][column term]

    def take(self, chosen: Integers | Mask | slice) -> "Population":
        """The individuals that an index array, a mask or a slice chooses."""
        arrays: Any = (array[chosen] for array in self)
        return Population(*arrays)


def joined(*populations: Population) -> Population:
    """Populations one after the other."""
    return Population(*(np.concatenate(arrays) for arrays in zip(*populations, strict=True)))


def vectors(population: Population) -> Floats:
    """The parameters as (n, parameters): gains, scales, consequents, as ``simulate`` has them."""
    count = len(population.tree)
    return np.concatenate([array.reshape(count, -1) for array in population[1:]], axis=1)


def from_vectors(parameters: Floats, like: Population) -> Population:
    """The individuals of ``parameters`` (n, parameters), all with the tree of ``like``."""
    count = len(parameters)
    shapes = [array.shape[1:] for array in like[1:]]
    parts = np.split(parameters, np.cumsum([int(np.prod(shape)) for shape in shapes])[:-1], axis=1)
    arrays = (part.reshape(count, *shape) for part, shape in zip(parts, shapes, strict=True))
    return Population(np.repeat(like.tree[:1], count), *arrays)


def controller_gains(population: Population) -> HierarchicalGains:
    """The population as ``simulate`` wants it: individuals in the trailing axis."""
    inputs = population.scales.shape[1]
    sources = hierarchy.all_sources(inputs)[population.tree]
    return HierarchicalGains(
        kp=population.gains[:, 0],
        kd=population.gains[:, 1],
        scales=population.scales.T,
        sources=np.moveaxis(sources, 0, -1),
        consequents=np.moveaxis(population.consequents, 0, -1),
    )
