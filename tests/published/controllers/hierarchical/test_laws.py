"""Linear laws as rule tables along trees: by hand, by SciPy, and what they are worth at once."""

import numpy as np
import pytest

from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs.problem import Problem


@pytest.mark.parametrize("name", ["c-axis-ramp", "c-axis-ramp-cutting", "feed-drive-hierarchy"])
def test_they_are_better_than_random_ones(name):
    own = Problem(load_scenario(name))
    tree = np.repeat(np.arange(own.genome.structures), 1 + 500 // own.genome.structures)
    rng = np.random.default_rng(5)
    ranks = [own.rank(first(tree, rng)) for first in (own.genome.informed, own.genome.fresh)]
    good, random = (np.quantile(np.where(np.isfinite(x), x, 0.0), 0.99) for x in ranks)
    assert good > 2.0 * random
