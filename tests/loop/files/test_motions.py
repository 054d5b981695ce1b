"""Scenarios of several motions: what each inherits, that they are judged as if alone."""

from four_motions import SEVERAL

from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs.problem import Problem
from hfc_design.simulation import compiled, population


def test_one_program_serves_any_number_of_motions():
    scenario = load_scenario(SEVERAL)
    problem = Problem(scenario)
    gains = problem.genome.gains(problem.genome.empty())
    parts = (problem._loop, population.one_machine(scenario.plant.values()))
    motions = [x.samples() for x in scenario.each_motion()]
    population.scores(*parts, motions, gains)
    before = compiled.scores._cache_size()
    population.scores(*parts, motions[::-1], gains)
    assert compiled.scores._cache_size() == before
