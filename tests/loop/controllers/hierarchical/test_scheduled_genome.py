"""A hierarchy that goes from one linear law to another: what a search makes of it."""

import numpy as np
import pytest
from scheduled import NAMES, SCALE, of_two_laws

from hfc_design.controllers.genome import taken
from hfc_design.core.checkpoint import flat
from hfc_design.files.design import Design
from hfc_design.runs.individuals import genome_of
from hfc_design.runtime import Controller


@pytest.fixture(scope="module")
def genome():
    return genome_of(of_two_laws())


def design_of(genome, individual):
    record = genome.record(individual) | {"sample_time_s": 0.001}
    plant = {"name": "c-axis", "parameters": {}}
    return Design.model_validate({"name": "one", "plant": plant, "controller": record})


def two_laws(genome, shares, seed=0, count=1):
    """Of the second stage: laws that differ, ``shares`` of the second, as it is steered by."""
    regulators = genome.stage(0, None)
    about = regulators.members(regulators.start[None], np.zeros(1, int))
    size = 2 + about.first.linear.shape[1]
    points = np.random.default_rng(seed).normal(0.0, 0.3, (count, 2 * size + 5))
    points[:, 2 * size :] = [*(np.array(shares) - [1.0, 0.0, 0.0, 1.0]), 0.0]
    return genome.stage(1, about).members(points, np.arange(count) % genome.structures), points


def columns(genome, population, second):
    """(n, 2 + ...) kp, kd, ki, gains on signals, of resonators, fed forward of one of both laws."""
    if second:
        return population.second
    return np.concatenate([population.first.fuzzy.gains, population.first.linear], axis=1)


def by_hand(genome, row, told, width):
    """A linear law of a row of ``columns``, the integral and the resonators at 0."""
    kp, kd, _, *gains = row
    velocity, acceleration, coulomb, _, load = gains[-5:]
    found = kp * told["error"] + kd * told["error_rate"] + load
    pairs = zip(genome.on_one.regulator.signals, gains, strict=False)
    found += sum(gain * told[name] for name, gain in pairs)
    found += velocity * told["reference_rate"] + acceleration * told["reference_acceleration"]
    return found + coulomb * np.clip(told["reference_rate"] / width, -1.0, 1.0)


def readings(design, count=40, **fixed):
    names, random = design.kind.reads(design.controller), np.random.default_rng(2)
    for row in random.normal(0.0, 0.1, (count, len(names))).tolist():
        yield dict(zip(names, row, strict=True)) | fixed


def test_first_individuals_are_one_linear_law_whatever_the_tables(genome):
    """To the bit: 0 times the root's output is added."""
    random = np.random.default_rng(1)
    first = genome.empty()
    populations = [taken(first, np.zeros(9, int))]
    populations.append(genome.fresh(np.zeros(9, int), random))
    for population in populations:
        own = genome.gains(population).scheduled
        for name, value in own._asdict().items():
            assert name == "width" or not np.any(value), name
        tables = population.first.fuzzy.consequents
        wild = population.first.fuzzy._replace(consequents=random.normal(0.0, 5.0, tables.shape))
        bent = population._replace(first=population.first._replace(fuzzy=wild))
        one = taken(bent, slice(1))
        design, row = design_of(genome, one), columns(genome, one, False)[0]
        for told in readings(design):
            width = one.first.linear[0, -2]
            expected = by_hand(genome, row, told, width)
            assert Controller(design).step(told) == pytest.approx(expected, rel=1e-12)


def test_in_between_it_is_the_weighted_average(genome):
    """Of Lin and Lee's terms, by exp and loops; the other inputs say nothing."""
    pair = genome_of(of_two_laws(NAMES[:2]))
    shares = np.array([0.8, 0.3, -0.1, 1.2])
    population, _ = two_laws(pair, shares)
    design = design_of(pair, population)
    first, second = (columns(pair, population, law)[0] for law in (False, True))
    width, terms = population.first.linear[0, -2], design.controller.terms
    for told in readings(design, 60):
        told["reference_rate"] *= 0.2
        u = min(max(told["reference_rate"] * SCALE, -1.0), 1.0)
        off = [max(abs(u - term.centre) - term.half_width, 0.0) for term in terms]
        degrees = [np.exp(-term.rate * x**2) for term, x in zip(terms, off, strict=True)]
        share = np.average(shares[[3, 2, 1, 0, 1, 2, 3]], weights=degrees)
        one, other = (by_hand(pair, law, told, width) for law in (first, second))
        expected = one + share * (other - one)
        assert Controller(design).step(told) == pytest.approx(expected, rel=1e-11)


def test_what_the_population_does_the_design_file_does():
    """To the bit, but for the load, which the file holds as gain times load."""
    linear = {"expected_load": 5.0, "load_frequencies_rad_s": [1.0, 50.0], "notch": True}
    genome, random = genome_of(of_two_laws(linear=linear)), np.random.default_rng(1)
    found, _ = two_laws(genome, [0.9, 0.2, 0.1, 0.7], seed=3, count=6)
    found = genome.mutated(found, np.full(6, 0.3), random)
    gains = genome.gains(found)
    for k in range(6):
        own = design_of(genome, taken(found, slice(k, k + 1))).controller
        parts = ((own.linear_part, gains.linear), (own.scheduled_part, gains.scheduled))
        for part, wanted in parts:
            for name, value in part.law_gains()._asdict().items():
                if name == "filters" and part.kind == "scheduled part":
                    assert getattr(wanted, name) == value == ()
                    continue
                each = np.ravel(np.asarray(getattr(wanted, name))[..., k])
                np.testing.assert_allclose(
                    np.ravel(value), each, rtol=1e-12 if name == "load" else 0.0, err_msg=name
                )
        tables = [unit.consequents for unit in own.units]
        np.testing.assert_array_equal(tables, np.asarray(gains.consequents)[..., k])
    assert gains.scheduled.load[0] != 0.0


def test_changed_and_mixed_individuals_are_of_the_same_shapes(genome):
    random = np.random.default_rng(5)
    one, _ = two_laws(genome, [1.0, 0.0, 0.0, 1.0], seed=1, count=4)
    other, _ = two_laws(genome, [0.5, 0.5, 0.5, 0.5], seed=2, count=4)
    share = np.array([0.0, 1.0, 0.5, 0.25])
    changed = {
        "mutated": genome.mutated(one, np.full(4, 0.1), random),
        "blended": genome.blended(one, other, share),
        "nudged": genome.nudged(one, random),
    }
    shapes = {name: array.shape for name, array in flat(one)}
    for told, population in changed.items():
        assert {name: array.shape for name, array in flat(population)} == shapes
        assert all(np.isfinite(array).all() for _, array in flat(population)), told
    mixed = changed["blended"]
    straight = one.second + share[:, None] * (other.second - one.second)
    np.testing.assert_array_equal(mixed.second, straight)
    np.testing.assert_allclose(
        mixed.first.linear,
        one.first.linear + share[:, None] * (other.first.linear - one.first.linear),
    )
    moved = changed["mutated"].second / one.second
    assert (moved > 0.0).all()
    assert (moved != 1.0).all()
    pairs = zip(flat(genome.mutated(one, np.zeros(4), random)), flat(one), strict=True)
    for (name, found), (_, wanted) in pairs:  # clipped consequents aside, no step is no change
        np.testing.assert_allclose(found, wanted, rtol=1e-15, err_msg=name)


@pytest.mark.parametrize("number", [1, 2])
def test_a_stage_begins_at_the_individual_that_it_is_about(number, genome):
    about, _ = two_laws(genome, [0.9, 0.1, -0.2, 1.3])
    stage = genome.stage(number, about)
    (found,) = (stage.members(stage.start[None], np.zeros(1, int)),)
    for (name, value), (_, wanted) in zip(flat(found), flat(about), strict=True):
        np.testing.assert_allclose(value, wanted, rtol=1e-9, atol=1e-12, err_msg=name)


def test_the_first_stage_begins_with_two_regulators_that_are_alike(genome):
    """With weights of their own they are those of the genome of one, at rest that of larger k_i."""
    stage = genome.stage(0, None)
    same = stage.members(stage.start[None], np.zeros(1, int))
    assert np.array_equal(columns(genome, same, False), columns(genome, same, True))
    points = stage.start + np.random.default_rng(3).normal(0.0, 0.1, (5, len(stage.start)))
    found, size = stage.members(points, np.zeros(5, int)), (len(stage.start) - 5) // 2
    halves = points[:, :size], points[:, size : 2 * size]
    alone = [genome.on_one.regulated(half, np.zeros(5, int)) for half in halves]
    both = [np.concatenate([one.fuzzy.gains, one.linear], axis=1) for one in alone]
    more = both[0][:, 2] > both[1][:, 2]  # k_i
    assert set(more.tolist()) == {True, False}
    for k in (0, 1):
        wanted = np.where(more[:, None], both[1 - k], both[k])
        np.testing.assert_array_equal(columns(genome, found, bool(k)), wanted)


def test_every_tree_passes_the_shares_on_to_the_root(genome):
    """As nearly as seven terms pass a value on; which inputs come beside the way is no matter."""
    population, _ = two_laws(genome, [1.0, 0.0, 0.0, 1.0], count=genome.structures)
    assert genome.structures > 1
    for k in range(genome.structures):
        design = design_of(genome, taken(population, slice(k, k + 1)))
        pair = (columns(genome, taken(population, slice(k, k + 1)), law)[0] for law in (0, 1))
        first, second = pair
        width = population.first.linear[k, -2]
        found = []
        for u in (0.0, 0.4, 0.8, -0.4, -0.8, 1.0):
            for told in readings(design, 6, reference_rate=u / SCALE):
                one, other = (by_hand(genome, law, told, width) for law in (first, second))
                found.append((u, (Controller(design).step(told) - one) / (other - one)))
        wanted = {u: expected_share(u, design.controller.terms) for u, _ in found}
        assert all(abs(share - wanted[u]) < 0.12 for u, share in found), design.controller.units


def expected_share(u, terms):
    off = [max(abs(u - term.centre) - term.half_width, 0.0) for term in terms]
    degrees = [np.exp(-term.rate * x**2) for term, x in zip(terms, off, strict=True)]
    return np.average([1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0], weights=degrees)
