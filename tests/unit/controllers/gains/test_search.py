"""Controllers whose gains are a few numbers, by search: pd and pid."""

import numpy as np
import pytest
from chance import mean_is, normal, uniform
from wording import refused

from hfc_design import api
from hfc_design.controllers.gains.genome import GainsGenome, GainVectors
from hfc_design.controllers.genome import taken
from hfc_design.controllers.kinds import KINDS
from hfc_design.search.loop import generations, searcher
from hfc_design.search.strategies.race import RaceSettings
from hfc_design.search.strategy import Task

RANGES = {"k_p": (0.1, 1000.0), "k_i": (0.0, 8.0), "k_d": (-1.0, 3.0)}
GENOME = GainsGenome(
    KINDS.get("pid").settings(kind="pid", ranges=RANGES),
    api.load_scenario("feed-drive-line").target,
)


def individuals(*places):
    return GainVectors(np.zeros(len(places), int), np.array(places, float))


def test_places_of_gains_in_their_ranges():
    """0.1 to 1000 are four decades; the other two ranges reach to zero or below it."""
    found = GENOME.gains(individuals([0.0, 0.0, 0.0], [0.25, 0.25, 0.25], [1.0, 1.0, 1.0]))
    np.testing.assert_allclose(found.k_p, [0.1, 1.0, 1000.0])
    np.testing.assert_allclose(found.k_i, [0.0, 2.0, 8.0])
    np.testing.assert_allclose(found.k_d, [-1.0, 0.0, 3.0])
    record = GENOME.record(individuals([0.5, 0.5, 0.5]))
    assert record == {"kind": "pid", "pid": pytest.approx({"k_p": 10.0, "k_i": 4.0, "k_d": 1.0})}


@pytest.mark.parametrize("seed", range(4))
def test_the_race_finds_the_best_gains(seed):
    """Of a score that has its best at k_p = 30, k_i = 6, k_d = -0.5."""

    def score(population, generation, needed=None):
        gains = GENOME.gains(population)
        off = np.log(gains.k_p / 30.0) ** 2 + (gains.k_i - 6.0) ** 2 + (gains.k_d + 0.5) ** 2
        return 1.0 / (1.0 + off)

    settings = RaceSettings(population=32, generations=150)
    race = searcher(settings, Task(GENOME))
    *_, search = generations(race, GENOME, 150, seed, score)
    found = GENOME.gains(search.archive.population)
    assert found.k_p[0] == pytest.approx(30.0, rel=1e-3)
    assert found.k_i[0] == pytest.approx(6.0, abs=1e-3)
    assert found.k_d[0] == pytest.approx(-0.5, abs=1e-3)


@pytest.mark.parametrize(("plant", "kind"), [("milling-table", "pd"), ("c-axis", "pid")])
def test_ranges_are_for_plants_of_their_units(plant, kind):
    def loaded(**ranges):
        own = {"controller": {"kind": kind, **ranges}}
        return api.load_scenario({"plant": {"name": plant}, **own})

    with refused() as found:
        loaded()
    assert "controller.ranges" in found.refusal
    own = {key: [1.0, 2.0] for key in KINDS.get(kind).settings.own_ranges._fields}
    with refused() as found:
        loaded(ranges=dict(list(own.items())[1:]))
    assert f"controller.ranges: {next(iter(own))}" in found.refusal
    assert set(loaded(ranges=own).controller.searched()) == {(1.0, 2.0)}


COUNT = 20_000


def middle(count=COUNT):
    return taken(GENOME.empty(), np.zeros(count, int))


def mutated(population, step, seed=31):
    return GENOME.mutated(population, np.full(COUNT, step), np.random.default_rng(seed))


def test_first_gains_fill_their_ranges():
    """Uniform: by its logarithm a gain that is always above zero, else by itself."""
    found = GENOME.gains(GENOME.fresh(np.zeros(COUNT, int), np.random.default_rng(32)))
    uniform(np.log10(found.k_p), -1.0, 3.0)
    uniform(found.k_i, 0.0, 8.0)
    uniform(found.k_d, -1.0, 3.0)
    places = np.stack([np.log10(found.k_p), found.k_i, found.k_d])
    assert np.abs(np.corrcoef(places) - np.eye(3)).max() < 5 / np.sqrt(COUNT)


def test_mutation_moves_seven_of_ten_gains_by_half_a_step():
    before = middle()
    moved = (mutated(before, 0.1).places - before.places) / (0.5 * 0.1)
    mean_is(moved != 0.0, np.full(3, 0.7))
    normal(moved[moved != 0.0])


def test_mutation_ends_at_the_ends_of_the_ranges():
    """From the middle, an end is one standard deviation away."""
    found = mutated(middle(), 1.0).places
    for end in (0.0, 1.0):
        mean_is(found == end, np.full(3, 0.7 * 0.15865525393145707))
    assert found.min() == 0.0
    assert found.max() == 1.0


def test_mixing_goes_on_a_straight_line_within_the_ranges():
    rng = np.random.default_rng(33)
    one, other = (GENOME.fresh(np.zeros(500, int), rng) for _ in range(2))
    share = rng.uniform(-0.25, 1.25, 500)
    line = one.places.T * (1 - share) + other.places.T * share
    found = GENOME.blended(one, other, share).places.T
    np.testing.assert_allclose(found, line.clip(0.0, 1.0), atol=1e-15)
    assert (found != line).any()
