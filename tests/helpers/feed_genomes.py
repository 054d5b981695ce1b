"""Genomes of a feed drive's controllers, and populations that were bred."""

import numpy as np

from hfc_design.controllers.genome import taken
from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs import individuals

CIRCLE = "feed-drive-circle"


def genome(kind, *changes):
    return individuals.genome_of(load_scenario(CIRCLE, [f"controller.kind={kind}", *changes]))


def bred(own, count=60, rounds=4):
    """A population after some rounds of mixing and wild mutation."""
    rng = np.random.default_rng(5)
    found = own.fresh(np.zeros(count, int), rng)
    for _ in range(rounds):
        other = taken(found, rng.permutation(count))
        mixed = own.blended(found, other, rng.uniform(-0.25, 1.25, count))
        found = own.mutated(mixed, np.full(count, 0.8), rng)
    return found
