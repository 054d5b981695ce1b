"""Searches of real controllers on short motions, against as many individuals drawn at random."""

import numpy as np
import pytest
import scipy.stats

from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs.problem import Problem
from hfc_design.search.loop import generations, searcher
from hfc_design.search.strategy import Task

SCALES = {"error": 50.0, "deflection": 80.0, "spindle_velocity": 20.0}
INPUTS = ", ".join(f"{{name='{name}', scale={scale}}}" for name, scale in SCALES.items())
CASES = {
    "hierarchy": ("c-axis-ramp", [f"controller.inputs=[{INPUTS}]", "simulation.duration_s=0.1"]),
    "table": ("feed-drive-circle", ["controller.kind=flc", "simulation.duration_s=4.0"]),
    "gains": ("feed-drive-line", ["controller={kind='pid'}", "simulation.duration_s=1.0"]),
}
COUNT, GENERATIONS, SEEDS = 32, 30, 8


@pytest.mark.parametrize("case", CASES)
def test_a_search_beats_as_many_individuals_drawn_at_random(case):
    """By more than chance, and without Gauss-Newton steps."""
    name, changes = CASES[case]
    sizes = [f"search.population={COUNT}", f"search.generations={GENERATIONS}"]
    scenario = load_scenario(name, [*changes, *sizes])
    problem = Problem(scenario)
    genome = problem.genome

    def searched(seed):
        own = searcher(scenario.search, Task(genome))
        *_, found = generations(own, genome, GENERATIONS, seed, problem.rank)
        return found.history.best[-1]

    def drawn(seed):
        rng = np.random.default_rng([seed, 1])
        trees = rng.integers(genome.structures, size=(GENERATIONS, COUNT))
        return max(problem.rank(genome.fresh(some, rng)).max() for some in trees)

    ours, theirs = ([every(seed) for seed in range(SEEDS)] for every in (searched, drawn))
    found = scipy.stats.mannwhitneyu(ours, theirs, alternative="greater")
    assert found.pvalue < 1e-3, (ours, theirs)
