"""First individuals of laws that were searched: on the trees that are asked for, and worth it."""

import numpy as np

from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs.first_laws import worthwhile
from hfc_design.runs.problem import Problem


def test_a_short_search_begins_with_regulators_that_nobody_simulated():
    assert not worthwhile(1000)
    problem = Problem(
        load_scenario("c-axis-ramp", {"search.population": 20, "search.generations": 5})
    )
    tree = np.array([7, 3, 3, 99, 7, 3])
    found = problem.task.informed(tree, np.random.default_rng(0))
    again = problem.genome.informed(tree, np.random.default_rng(0))
    assert problem.simulated == 0
    assert np.array_equal(found.consequents, again.consequents)
