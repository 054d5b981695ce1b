"""The population simulator: published scores, independence of individuals, sensors, Jacobian."""

import numpy as np
import oracle
import pytest
from lifted import every_axis
from populations import HIERARCHICAL, fitness, picked, prepared, trajectory

from hfc_design.controllers.controller import AxisLaw
from hfc_design.controllers.hierarchical.law import HierarchicalGains, Layout, hierarchical
from hfc_design.controllers.pd import PdGains, initial_memory, sample
from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.simulation import population as simulate
from hfc_design.simulation.evaluating import evaluate


# Values of an independent float64 implementation, 10 s.
@pytest.mark.parametrize(
    ("design", "scenario", "score"),
    [
        ("lin-lee-1999-table-1", "c-axis-ramp", 380.5715),
        ("pd-only", "c-axis-ramp", 80.0197),
        ("lin-lee-1999-table-2", "c-axis-ramp-cutting", 22.0256),
    ],
)
def test_published_score(design, scenario, score):
    found = evaluate(load_design(design), load_scenario(scenario))
    assert found.fitness == pytest.approx(score, abs=6e-5)
    assert not found.diverged


@pytest.mark.parametrize(
    ("design", "scenario"),
    [("lin-lee-1999-table-1", "c-axis-ramp"), ("lin-lee-1999-table-2", "c-axis-ramp-cutting")],
)
def test_float32_agrees_on_published_controllers(design, scenario, published):
    controller, gains = published(design)
    loop = prepared(controller, scenario=scenario, seconds=10)
    single, double = (fitness(*loop, gains, kind) for kind in (np.float32, np.float64))
    assert single == pytest.approx(double, rel=1e-4)
    assert single != double


def test_score_is_equation_5(random_population):
    gains = random_population(5, seed=1)
    loop = prepared(HIERARCHICAL)
    judged, (motion,) = trajectory(*loop, gains)
    scores = judged.values[:, 0]
    sums = abs(motion.error).sum(axis=0), abs(motion.error_rate).sum(axis=0)
    assert scores == pytest.approx(3000 / sums[0] + 100 / sums[1], rel=1e-12)
    assert fitness(*loop, gains, np.float64) == pytest.approx(scores, rel=1e-12)


@pytest.mark.parametrize("count", [1, 17, 65, 130])
def test_population_equals_a_loop_over_individuals(count, random_population):
    gains = random_population(130, seed=2)
    loop = prepared(HIERARCHICAL)
    # One at a time and through the other door: shape (steps, 1), without padding or chunks.
    alone = [trajectory(*loop, picked(gains, [one]))[0].values[0, 0] for one in range(0, count, 7)]
    together = fitness(*loop, picked(gains, slice(count)), np.float64)
    assert together.shape == (count,)
    assert len(set(together)) == count
    assert together[::7] == pytest.approx(alone, rel=1e-12)


def test_diverging_individual_is_alone_in_it(random_population):
    gains = random_population(65, seed=5)
    loop = prepared(HIERARCHICAL)
    kd = gains.kd.copy()
    kd[[3, 20]] = 1e9
    for dtype in (np.float32, np.float64):
        healthy = fitness(*loop, gains, dtype)
        found = fitness(*loop, gains._replace(kd=kd), dtype)
        assert np.flatnonzero(np.isnan(found)).tolist() == [3, 20]
        others = ~np.isnan(found)
        assert (found[others] == healthy[others]).all()


def test_substeps_converge():
    """At 2 ms and with a fast load; until the spindle reverses nothing has a corner."""
    gains = PdGains(np.array([800.0]), np.array([700.0]))
    finals = []
    for substeps in (1, 2, 4):
        changes = ("simulation.sample_time_s=0.002", f"simulation.substeps={substeps}")
        pd = every_axis("pd", AxisLaw(sample, initial_memory, 0.002))
        loop = prepared(pd, *changes, seconds=0.1)
        _, (motion,) = trajectory(*loop, gains)
        assert (motion.state.spindle_velocity <= 0).all()
        finals.append(np.array([part[-1, 0] for part in motion.state]))
    exact, _ = oracle.closed_loop(
        None, 800.0, 700.0, 0.098, oracle.cutting_load, "DOP853", sample=0.002, rtol=1e-12
    )
    errors = [np.max(abs(final / exact[-1] - 1)) for final in finals]
    assert errors[0] > 12 * errors[1] > 12 * 12 * errors[2]
    assert errors[2] < 2e-9


@pytest.mark.parametrize(("inputs", "firing"), [(3, 40), (5, 90)])
def test_error_jacobian_is_the_central_difference(inputs, firing, published, random_population):
    if inputs == 5:
        controller, gains = published("lin-lee-1999-table-1")
    else:
        law = hierarchical(Layout(Layout().inputs[:inputs]), 0.001)
        controller = every_axis("pd+hierarchical-fuzzy", law)
        gains = random_population(1, seed=7, inputs=inputs)
    loop = prepared(controller, scenario="c-axis-ramp", seconds=0.3)
    error, jacobian = simulate.jacobians(*loop, gains, ("error",), np.float64)["error"]
    floating = (gains.kp, gains.kd, gains.scales, gains.consequents)
    start = np.concatenate([leaf.ravel() for leaf in floating])
    assert jacobian.shape == (300, len(start))
    _, (motion,) = trajectory(*loop, gains)
    np.testing.assert_allclose(error, motion.error[:, 0], atol=1e-15)

    # All the moved copies are one population: a column a parameter, ahead and behind.
    steps = 1e-4 * np.maximum(abs(start), 1.0)
    moved = start[:, None] + np.hstack([np.diag(steps), -np.diag(steps)])
    kp, kd, scales, tables = np.split(moved, np.cumsum([leaf.size for leaf in floating])[:-1])
    sources = np.repeat(gains.sources, 2 * len(start), axis=2)
    tables = tables.reshape(inputs - 1, 7, 7, -1)
    copies = HierarchicalGains(kp[0], kd[0], scales, sources, tables)
    _, (motion,) = trajectory(*loop, copies)
    ahead, behind = np.split(motion.error, 2, axis=1)
    difference = abs(jacobian - (ahead - behind) / (2 * steps)).max(axis=0)
    size = abs(jacobian).max(axis=0)
    assert (size > 1e-8).sum() > firing  # the others are rules that hardly fire
    assert (difference < 1e-6 * size + 1e-12).all()  # 1e-12 is the rounding of the difference


def test_order_of_individuals_does_not_matter(random_population):
    gains = random_population(65, seed=3)
    loop = prepared(HIERARCHICAL)
    order = np.random.default_rng(1).permutation(65)
    for dtype in (np.float32, np.float64):
        scores = fitness(*loop, gains, dtype)
        reordered = fitness(*loop, picked(gains, order), dtype)
        np.testing.assert_array_equal(reordered, scores[order])


def test_published_score_of_the_second_pd_alone():
    pd = every_axis("pd", AxisLaw(sample, initial_memory, 0.001))
    prepared_loop = prepared(pd, seconds=10)
    gains = PdGains(np.array([1002.076]), np.array([135.007]))
    assert fitness(*prepared_loop, gains, np.float64)[0] == pytest.approx(10.4647, abs=6e-5)


def test_command_limit_is_kept(published):
    controller, gains = published("lin-lee-1999-table-2")
    _, (free,) = trajectory(*prepared(controller), gains)
    _, (held,) = trajectory(*prepared(controller, "limits.command=25.0"), gains)
    assert abs(free.command).max() > 30
    assert abs(held.command).max() == 25.0
    inside = free.command[:, 0] < 25.0
    first = np.argmin(inside)
    assert (held.command[:first] == free.command[:first]).all()
    assert held.command[first] == 25.0
