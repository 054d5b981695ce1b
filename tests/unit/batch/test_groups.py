"""Runs that belong together, and whether groups of them differ."""

import itertools

import numpy as np
import pytest
import scipy.stats
from run_folders import PRESETS, batch_folder, reported, run_folder

from hfc_design.batch.findings import compared, grouped, runs_needed, smallest_p
from hfc_design.batch.results import runs_below


def test_groups_by_hand(tmp_path):
    batch_folder(tmp_path, PRESETS)
    groups = grouped(runs_below(tmp_path))
    told = [
        (group.number, group.task, *group.settings.values(), *group.quartiles) for group in groups
    ]
    assert told == [
        (1, "a", "a", "race", 11.0, 12.0, 13.0),
        (2, "a", "a", "third", 5.0, 5.0, 5.0),
        (3, "a", "a", "lin-lee-1999", 2.0, 3.0, 4.0),
        (4, "b", "b", "race", 0.0, 0.0, 0.0),
    ]
    assert groups[2].label == "3: preset lin-lee-1999"


def test_comparisons_against_enumeration_and_scipy(tmp_path):
    batch_folder(tmp_path, PRESETS)
    found = compared(grouped(runs_below(tmp_path)))
    assert [(item.first.number, item.second.number) for item in found] == [(1, 2), (1, 3), (2, 3)]
    for item in found:
        x, y = item.first.scores, item.second.scores
        assert item.p == scipy.stats.mannwhitneyu(x, y).pvalue
        assert item.a12 == sum((a > b) + 0.5 * (a == b) for a in x for b in y) / 25
    # 1 and 3 have no ties: p is the share of the 252 ways to deal ten ranks that differ as much
    x, y = found[1].first.scores, found[1].second.scores
    every = np.concatenate([x, y])

    def wins(own):
        others = [k for k in range(10) if k not in own]
        return sum(every[a] > every[b] for a in own for b in others)

    seen = abs(wins(range(5)) - 12.5)
    as_far = [abs(wins(own) - 12.5) >= seen for own in itertools.combinations(range(10), 5)]
    assert found[1].p == pytest.approx(np.mean(as_far), rel=1e-12)
    p = sorted(item.p for item in found)
    corrected = sorted(item.holm for item in found)
    assert corrected[0] == 3 * p[0]
    assert corrected[1] == max(3 * p[0], 2 * p[1])


def test_how_few_runs_are_too_few():
    assert smallest_p(4, 4) == pytest.approx(2 / 70)
    assert smallest_p(1, 1) == 1.0
    assert smallest_p(5, 5) == scipy.stats.mannwhitneyu(range(5), range(5, 10)).pvalue
    assert runs_needed(1) == 4  # 3 and 3: 2/20
    assert runs_needed(3) == 5  # 3 * 2/70 is too much, 3 * 2/252 is not


def test_a_seed_run_twice_counts_once(tmp_path):
    for name, seed in (("one", 0), ("two", 0), ("three", 1)):
        run_folder(tmp_path / name, 1.0 + seed)
        (tmp_path / name / "config.toml").write_text(f'name = "mine"\n[run]\nseed = {seed}\n')
    (group,) = grouped(runs_below(tmp_path))
    assert group.scores.tolist() == [1.0, 2.0]
    assert len(group.runs) == 3
    assert "settings and seed of another (1)" in reported(tmp_path)[1]


def test_runs_outside_of_batches_are_told_apart_by_their_configuration(tmp_path):
    """What only the scenario explains is no setting; what differs inside a scenario is."""
    configs = {
        "x/a": 'name = "ramp"\n[search]\npopulation = 10\n[load]\nconstant = 0.0\n',
        "x/b": 'name = "ramp"\n[search]\npopulation = 20\n[load]\nconstant = 0.0\n',
        "c": 'name = "cut"\n[search]\npopulation = 10\n[load]\nconstant = 5.0\n',
    }
    for name, text in configs.items():
        run_folder(tmp_path / name, 1.0)
        (tmp_path / name / "config.toml").write_text(text + "[run]\nseed = 0\n")
    batch_folder(tmp_path / "y", [({"scenario": "sine"}, [3.0])])
    runs = runs_below(tmp_path)
    assert [run.path for run in runs] == ["y/" + "0" * 16, "c", "x/a", "x/b"]
    assert [group.settings for group in grouped(runs)] == [
        {"scenario": "sine", "search.population": "–"},
        {"scenario": "cut", "search.population": "10"},
        {"scenario": "ramp", "search.population": "10"},
        {"scenario": "ramp", "search.population": "20"},
    ]


def test_scores_of_different_fitness_are_not_compared(tmp_path):
    groups = [({"fitness.worst": worst}, [1.0, 2.0, 3.0]) for worst in (0.1, 0.3)]
    batch_folder(tmp_path, groups)
    found = grouped(runs_below(tmp_path))
    tasks = ["c-axis-ramp, fitness.worst 0.1", "c-axis-ramp, fitness.worst 0.3"]
    assert [group.task for group in found] == tasks
    assert compared(found) == []
