"""The experiment search_power: its statistics by brute force, its searches beside the package's."""

import json
from itertools import combinations, product
from pathlib import Path

import jax
import numpy as np
import pytest
from click.testing import CliRunner
from experiment_pages import page_of, table

from experiments.search_power import figures, page
from experiments.search_power.lockstep import CHECKS, together
from experiments.search_power.methods import DEFAULT, names
from experiments.search_power.plain import LShade
from experiments.search_power.searches import Setup, peer, strategy
from experiments.search_power.tasks import Field, Ground
from hfc_design.controllers.genome import taken
from hfc_design.runs.problem import Problem
from hfc_design.search.loop import generations, searcher

SMALL = {"limits.command": 250.0, "simulation.duration_s": 0.3, "search.population": 120}
PEER = names()[2]


@pytest.fixture(scope="module")
def field():
    return Field(Ground("ramp", "c-axis-ramp", SMALL, 1500))


@pytest.fixture
def results(tmp_path):
    """Two methods on a task and one on another, of eight seeds with known values."""
    rng = np.random.default_rng(3)
    levels = {("ramp", DEFAULT): 3.0, ("ramp", PEER): 2.0, ("cutting", PEER): 1.0}
    for (task, method), level in levels.items():
        best = level * np.sort(rng.random((8, 5)), axis=1)
        own = {"task": task, "method": method, "budget": 100, "shares": [0.2, 0.4, 0.6, 0.8, 1.0]}
        own |= {"seconds": np.sort(rng.random((8, 5)), axis=1).tolist()}
        own |= {"best": [[None, *row[1:]] for row in best.tolist()], "final": best[:, -1].tolist()}
        (tmp_path / f"{task}.{names().index(method)}.json").write_text(json.dumps(own))
    return tmp_path


def test_the_default_is_compared_as_by_counting(results):
    found = figures.read(results)
    (one,) = figures.beaten(found)
    own, other = (x.final for x in found["ramp"])
    wins = sum((a > b) + 0.5 * (a == b) for a, b in product(own, other))
    assert one.a12 == pytest.approx(wins / 64.0, abs=1e-12)
    # The share of all ways to deal sixteen values whose U lies as far from its middle.
    both = np.concatenate([own, other])
    rank = np.argsort(np.argsort(both))
    sums = np.array([rank[list(some)].sum() for some in combinations(range(16), 8)])
    far = np.abs(sums - sums.mean())
    assert one.p == pytest.approx(np.mean(far >= far_of(rank, sums) - 1e-9), rel=1e-9)
    assert one.holm == one.p


def far_of(rank, sums):
    return abs(rank[:8].sum() - sums.mean())


def test_targets_are_reached_as_by_counting(results):
    (one, other) = figures.read(results)["ramp"]
    wanted = figures.targets([one, other])
    assert len(wanted) == figures.TARGETS
    assert wanted[-1] == pytest.approx(max(one.final.max(), other.final.max()))
    ratios = wanted[1:] / wanted[:-1]
    assert np.allclose(ratios, ratios[0])
    for k in range(5):
        hits = [seed[k] >= x * (1 - 1e-9) for seed in one.best for x in wanted]
        assert figures.reached(one, wanted)[k] == pytest.approx(np.mean(hits))
    at = figures.reached_by(one, wanted, np.array([0.5]))[0]
    hits = []
    for best, seconds in zip(one.best, one.seconds, strict=True):
        known = max((b for b, s in zip(best, seconds, strict=True) if s <= 0.5), default=-np.inf)
        hits += [known >= x * (1 - 1e-9) for x in wanted]
    assert at == pytest.approx(np.mean(hits))


def test_a_page_without_results_says_so(tmp_path):
    found = CliRunner().invoke(page.main, ["--results", str(tmp_path)])
    assert found.exit_code == 2
    assert "run python -m experiments.search_power.run first" in found.output


def test_the_page_is_that_of_its_results():
    folder = Path(page.__file__).parent / "results"
    if not folder.exists():
        pytest.skip("the experiment has not been run")
    rows = figures.table(figures.read(folder))
    told = [row for row in table(page_of(page)) if len(row) == len(figures.HEADER)]
    assert [row for row in told if row[0] in figures.GROUNDS] == rows


def test_on_many_machines_the_default_meets_those_of_the_package():
    """Hard ones too, which are asked for in the last generations: the same incumbent."""
    changes = {"search.generations": 45, "robust.final": 24}
    robust = Field(Ground("practical", "c-axis-practical", changes, 10_000))
    settings = robust.scenario.search
    (found,) = together(lambda *own: strategy(settings, *own), robust, [3])
    problem = Problem(robust.scenario)
    own = searcher(settings, problem.task), problem.genome, 45, 3
    *_, last, _ = generations(*own, problem.scored)
    best = taken(last.state.population, np.argsort(-last.state.score, kind="stable")[:1])
    ours = jax.tree.leaves(taken(found.incumbents[-1], slice(1)))
    for one, other in zip(jax.tree.leaves(best), ours, strict=True):
        assert np.array_equal(one, other)
    more = settings.model_copy(update={"hardened": 0.0})
    (without,) = together(lambda *own: strategy(more, *own), robust, [3])
    assert without.spent < found.spent  # who is hard is paid for


def test_nobody_spends_more_than_the_budget(field):
    setup = Setup(LShade, 20, 2.0)
    (found,) = together(lambda *own: peer(setup, *own), field, [1])
    assert 0.9 * field.budget < found.spent <= field.budget
    assert (np.diff(found.best[np.isfinite(found.best)]) >= 0.0).all()
    assert len(found.incumbents) == len(CHECKS)
