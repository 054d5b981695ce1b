"""The paper's operators, one by one (Lin & Lee 1999, section 3.1 and 3.2)."""

import itertools

import numpy as np
import pytest
import scipy.stats
from hierarchies import searched_of, valid

from hfc_design.controllers.hierarchical import tree as hierarchy
from hfc_design.controllers.hierarchical.law import LIN_LEE_INPUTS
from hfc_design.search.strategies.lin_lee import LinLee, LinLeeSettings, two_point
from hfc_design.search.strategy import Task

GENOME = searched_of(LIN_LEE_INPUTS)


def bits(text):
    return np.array([int(c) for c in text], bool)


def started(seed=0, **settings):
    search = LinLee(LinLeeSettings(**settings), Task(GENOME))
    rng = np.random.default_rng(seed)
    _, asked = search.start(rng)
    state = search.tell(None, asked, rng.random(len(asked.genes)))
    return search, state, rng


def counts(trees):
    """How often each tree was drawn, and how often if valid genes are equally likely."""
    everything = np.array(list(itertools.product(range(8), repeat=5)))
    genes = everything[valid(everything)].tolist()
    index = {tree: k for k, tree in enumerate(hierarchy.trees(5))}
    share = np.bincount([index[hierarchy.decode(gene)] for gene in genes]) / len(genes)
    common = share * len(trees) > 5  # a chi-square test wants more than five in each class
    observed = np.bincount(trees, minlength=105)
    return tuple(
        np.append(array[common], array[~common].sum()) for array in (observed, share * len(trees))
    )


def test_two_point_crossover_of_the_papers_example():
    pair = np.array([bits("11000001"), bits("00111110")])
    crossed = two_point(pair, 2, 7)  # "points m = 2 and n = 7"
    assert np.array_equal(crossed, [bits("11111111"), bits("00000000")])


def test_defaults_are_the_papers_numbers():
    settings = LinLeeSettings()
    assert settings.population == 30
    assert (settings.structure_crossover, settings.structure_mutation) == (0.3, 0.5)
    assert (settings.parameter_crossover, settings.parameter_mutation) == (0.7, 0.8)
    assert (settings.gain_step, settings.centre_step) == (10.0, 0.1)


def test_first_generation_is_valid_and_looks_like_the_printed_tables():
    _, state, _ = started(population=600)
    for gene, tree in zip(state.genes.tolist(), state.population.tree.tolist(), strict=True):
        assert hierarchy.decode(gene) == hierarchy.trees(5)[tree]
    tables = state.population.consequents
    spread = tables.max(axis=(2, 3)) - tables.min(axis=(2, 3))
    assert spread.max() <= 0.2  # Tables I and II: +/- 0.1 about a common level
    assert np.abs(tables.mean(axis=(2, 3))).max() > 1.5  # Table II's level is 1.64
    assert scipy.stats.chisquare(*counts(state.population.tree)).pvalue > 1e-3


def test_best_third_survives_unchanged_and_in_order():
    search, state, rng = started(population=31)
    _, asked = search.ask(state, 1, rng)
    assert len(asked.genes) == 31
    assert np.array_equal(asked.genes[:10], state.genes[:10])
    assert np.array_equal(asked.population.consequents[:10], state.population.consequents[:10])
    assert (np.diff(state.score) <= 0).all()


def test_crossed_third_has_valid_genes_made_of_parents_bits():
    search, state, rng = started(population=300)
    _, asked = search.ask(state, 1, rng)
    crossed = asked.genes[100:200]
    for gene in crossed.tolist():
        assert hierarchy.decode(gene) is not None
    parents = {tuple(gene) for gene in state.genes.tolist()}
    copied = sum(tuple(gene) in parents for gene in crossed.tolist())
    # p_c1 = 0.3: seven of ten pairs are copies; a crossed pair is often invalid and drawn again.
    assert 60 <= copied < 100


def test_children_that_share_a_structure_with_two_parents_average_them():
    search, state, rng = started(population=450, parameter_crossover=1.0)
    _, asked = search.ask(state, 1, rng)
    averaged = 0
    for child in range(150, 300):
        parents = np.flatnonzero(state.population.tree == asked.population.tree[child])
        kp = state.population.gains[parents, 0]
        table = state.population.consequents[parents]
        for a in range(len(parents)):
            for b in range(a):
                w = (asked.population.gains[child, 0] - kp[b]) / (kp[a] - kp[b])
                mixed = w * table[a] + (1 - w) * table[b]
                if np.allclose(mixed, asked.population.consequents[child], atol=1e-12):
                    assert 0 < w < 1
                    averaged += 1
    assert averaged > 75


@pytest.mark.parametrize("share", [0.0, 0.8, 1.0])
def test_mutation_moves_the_given_share_by_at_most_a_max(share):
    search, state, rng = started(population=300, parameter_mutation=share)
    _, asked = search.ask(state, 1, rng)
    moved = changed = total = 0
    for child in range(200, 300):
        distance = np.abs(state.population.consequents - asked.population.consequents[child])
        parent = distance.mean(axis=(1, 2, 3)).argmin()
        assert distance[parent].max() <= 0.1
        gains = np.abs(state.population.gains[parent] - asked.population.gains[child])
        assert gains.max() <= 10.0
        changed += np.count_nonzero(distance[parent])
        total += distance[parent].size
        moved += gains.max() > 0
        assert hierarchy.decode(asked.genes[child].tolist()) is not None
    assert changed / total == pytest.approx(share, abs=0.01)
    assert (moved > 0) == (share > 0)


def test_half_of_the_bits_flip():
    search, state, rng = started(population=3000)
    _, asked = search.ask(state, 1, rng)
    # With alpha = 0.5 a mutated gene is a fresh draw among the 6,300 valid ones.
    assert scipy.stats.chisquare(*counts(asked.population.tree[2000:])).pvalue > 1e-3
