"""First individuals of laws that were searched: on the trees that are asked for, and worth it."""

import numpy as np
import pytest

from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs.first_laws import FEWEST
from hfc_design.runs.problem import Problem

SHORT = ["simulation.duration_s=1.0", "limits.command=250.0"]


def begun(name, *changes, seed=0):
    problem = Problem(load_scenario(name, [*SHORT, *changes]))
    tree = np.array([7, 3, 3, 99, 7, 3])
    return problem, problem.task.informed(tree, np.random.default_rng(seed)), tree


@pytest.mark.parametrize("name", ["c-axis-ramp", "c-axis-ramp-cutting"])
def test_laws_that_were_searched_are_better_than_regulators(name):
    problem, found, tree = begun(name, "search.population=200", "search.generations=100")
    assert np.array_equal(found.tree, tree)
    rank = problem.rank(found)
    rng = np.random.default_rng(1)
    others = problem.rank(problem.genome.informed(np.repeat([3, 7, 99], 200), rng))
    assert rank.max() > 1.2 * others.max()


def test_a_short_search_begins_with_regulators_that_nobody_simulated():
    assert FEWEST > 1000
    problem, found, tree = begun("c-axis-ramp", "search.population=20", "search.generations=5")
    again = problem.genome.informed(tree, np.random.default_rng(0))
    assert problem.simulated == 0
    assert np.array_equal(found.consequents, again.consequents)
