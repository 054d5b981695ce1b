"""Scenarios of several motions: what each inherits, that they are judged as if alone."""

from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs.problem import Problem
from hfc_design.simulation import compiled, population

#: Four motions of different lengths, one with a load, one with a start of its own.
MOTIONS = [
    {"name": "ramp", "duration_s": 0.3},
    {"name": "creep", "reference": {"kind": "ramp", "velocity": 0.002}, "weight": 2.0},
    {"name": "cut", "duration_s": 0.15, "load": {"constant": 5.0}, "settled_after_s": 0.1},
    {
        "name": "step",
        "duration_s": 0.1,
        "reference": {"kind": "step", "height": 0.01},
        "start": {"spindle_angle": 0.001, "rotor_angle": 0.001},
    },
]
SEVERAL = {"name": "several", "simulation": {"duration_s": 0.2}, "motions": MOTIONS}


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
