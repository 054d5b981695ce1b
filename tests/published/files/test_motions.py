"""Scenarios of several motions: what each inherits, that they are judged as if alone."""

import numpy as np
from four_motions import SEVERAL
from populations import trajectory

from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs.problem import Problem
from hfc_design.simulation import compiled, population


def test_several_are_judged_as_each_alone():
    """The same bits, whatever lies before or behind a motion."""
    scenario = load_scenario(SEVERAL)
    problem = Problem(scenario)
    genome = problem.genome
    random = genome.fresh(np.arange(64) % genome.structures, np.random.default_rng(0))
    motions, gains = [x.samples() for x in scenario.each_motion()], genome.gains(random)
    parts = (problem.loop, population.one_machine(scenario.plant.values()))
    together = population.scores(*parts, motions, gains)
    for k, samples in enumerate(motions):
        alone = population.scores(*parts, [samples], gains)
        fine = ~alone.failed[:, 0, 0]
        assert fine.sum() > 40
        assert np.array_equal(together.failed[..., k], alone.failed[..., 0])
        assert np.array_equal(together.merit[fine, :, k], alone.merit[fine, :, 0])
    assert len(set(together.merit[fine][0, 0])) == 4


def test_motions_that_are_recorded_together_are_those_of_each_alone():
    scenario = load_scenario(SEVERAL)
    problem = Problem(scenario)
    rng = np.random.default_rng(3)
    gains = problem.genome.gains(problem.genome.fresh(np.arange(3), rng))
    parts = (problem.loop, population.one_machine(scenario.plant.values()))
    motions = [x.samples() for x in scenario.each_motion()]
    before = compiled.trajectories._cache_size()
    together = population.trajectories(*parts, motions, gains, 2)
    assert compiled.trajectories._cache_size() == before + 1
    assert len({len(samples.time) for samples in motions}) > 1  # of several lengths
    for samples, (judged, (motion,), _) in zip(motions, together, strict=True):
        alone, (own,) = trajectory(*parts, samples, gains, 2)
        assert motion.error.shape == (len(samples.time), 2)
        assert judged.merit.shape == (3,)
        np.testing.assert_allclose(motion.error, own.error, rtol=1e-9, atol=1e-15)
        np.testing.assert_allclose(motion.command, own.command, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(judged.merit, alone.merit, rtol=1e-9)


def test_one_program_serves_any_number_of_motions():
    scenario = load_scenario(SEVERAL)
    problem = Problem(scenario)
    gains = problem.genome.gains(problem.genome.empty())
    parts = (problem.loop, population.one_machine(scenario.plant.values()))
    motions = [x.samples() for x in scenario.each_motion()]
    population.scores(*parts, motions, gains)
    before = compiled.scores._cache_size()
    population.scores(*parts, motions[::-1], gains)
    assert compiled.scores._cache_size() == before
