"""What runs of many are compared by: the merit where all were judged alike, else the fitness."""

import json

import numpy as np
import pytest
from run_folders import PRESETS, batch_folder, hfc, reported, table, with_score

from hfc_design.batch.findings import compared, grouped
from hfc_design.batch.results import runs_below

HARD = "fitness, LL eq. 5 / (1 + 300 stick share)"


def judge(out, names, merits, title=HARD):
    """Let finished runs be judged: the fitness stays, None is a design that diverged."""
    for name, merit in zip(names, merits, strict=True):
        lost = {"fitness": None} if merit is None else {}
        with_score(out / name, merit=merit, judged_by=title, **lost)


def page(out):
    return reported(out)[1]


def test_runs_judged_alike_are_compared_by_their_merit(tmp_path):
    """The fitness says the reverse."""
    groups = [
        ({"search.preset": "a"}, [10.0, 11.0, 12.0]),
        ({"search.preset": "b"}, [1.0, 2.0, 3.0]),
    ]
    names = batch_folder(tmp_path, groups)
    judge(tmp_path, names, [4.0, 5.0, 6.0, 7.0, 8.0, 9.0])
    first, second = grouped(runs_below(tmp_path))
    assert (first.settings, first.quartiles) == ({"search.preset": "b"}, (7.5, 8.0, 8.5))
    assert (first.measure, second.scores.tolist()) == (HARD, [4.0, 5.0, 6.0])
    assert compared([first, second])[0].a12 == 1.0
    assert f"Median, quartiles and best of {HARD} over runs" in page(tmp_path)
    rows = table(tmp_path / "runs.csv")
    assert {row["judged_by"] for row in rows} == {HARD}
    assert [row["merit"] for row in rows[:2]] == ["4.0", "5.0"]
    (row,) = table(tmp_path / "comparisons.csv")
    assert (row["measure"], row["group"]) == (HARD, "1")
    assert table(tmp_path / "groups.csv")[0]["merit_median"] == "8.0"


@pytest.mark.parametrize("title", ["fitness, LL eq. 5", None])
def test_runs_judged_in_two_ways_are_compared_by_their_fitness(title, tmp_path):
    """None is a run of an earlier version."""
    groups = [({"search.preset": "a"}, [10.0, 11.0]), ({"search.preset": "b"}, [1.0, 2.0])]
    names = batch_folder(tmp_path, groups)
    judge(tmp_path, names[:2], [4.0, 5.0])
    if title:
        judge(tmp_path, names[2:], [7.0, 8.0], title)
    first, second = grouped(runs_below(tmp_path))
    assert (first.measure, first.median, second.median) == ("fitness", 10.5, 1.5)
    assert "Median, quartiles and best of fitness over runs" in page(tmp_path)


def test_what_diverged_is_last_in_its_group_and_no_number_in_a_file(tmp_path):
    groups = [({"search.preset": "a"}, [1.0] * 4), ({"search.preset": "b"}, [1.0] * 4)]
    names = batch_folder(tmp_path, groups)
    judge(tmp_path, names, [None, None, None, -5.0, -7.0, -8.0, None, -9.0])
    first, second = grouped(runs_below(tmp_path))
    assert first.settings == {"search.preset": "b"}
    assert np.sort(first.scores).tolist() == [-np.inf, -9.0, -8.0, -7.0]
    assert first.median == -8.5
    assert second.median == -np.inf
    assert compared([first, second])[0].a12 == (9 + 3 * 0.5) / 16  # -5 beats all; 3 ties
    text = page(tmp_path)
    assert "diverged" in text
    assert "inf" not in (tmp_path / "groups.csv").read_text()
    assert "inf" not in (tmp_path / "runs.csv").read_text()


TWO = [
    ({"scenario": "a", "search.preset": "race"}, [430.0, 440.0]),
    ({"scenario": "a", "search.preset": "cma"}, [400.0, 401.0]),
]


def made_chaotic(folder, lowest, highest):
    ends = {"lowest": lowest, "median": None, "highest": highest, "count": 64}
    with_score(folder, chaotic=True, repeats={"fitness": ends})


def test_it_counts_with_the_lower_end_and_is_told_as_a_range(tmp_path):
    first, second, *_ = batch_folder(tmp_path, TWO)
    made_chaotic(tmp_path / first, 362.04, 511.0)
    made_chaotic(tmp_path / second, 398.0, 441.0)
    _, page = reported(tmp_path)
    groups = table(tmp_path / "groups.csv")
    assert [row["search.preset"] for row in groups] == ["cma", "race"]
    assert [float(row["fitness_median"]) for row in groups] == [400.5, pytest.approx(380.02)]
    runs = {row["run"]: row for row in table(tmp_path / "runs.csv")}
    assert [runs[name]["fitness"] for name in (first, second)] == ["362.04", "398.0"]
    assert [row["fitness_highest"] for row in runs.values()] == ["511.0", "441.0", "", ""]
    assert '<td class="value">362 to 511 (chaotic)</td>' in page
    assert "430.0</td>" not in page
    assert "A chaotic design (2) has a range (in 64 repeats" in page


def test_a_ratio_over_zero_is_none(tmp_path):
    own, other = ({"scenario": "a", "search.preset": x} for x in ("race", "third"))
    names = batch_folder(tmp_path / "out", [(own, [0.0, 0.0]), (other, [0.0, 0.0])])
    sides = [{"of": own, "over": other}, {"of": own}]
    figures = [{"quantity": "q", "value": 0.0, "metric": "fitness", **side} for side in sides]
    plan = json.loads((tmp_path / "out" / "batch.json").read_text())
    plan["files"] = {"mine": {"published": figures}}
    (tmp_path / "out" / "batch.json").write_text(json.dumps(plan))
    done = hfc("report", tmp_path / "out")
    assert done.exit_code == 0, done.output
    rows = table(tmp_path / "out" / "published.csv")
    assert [row["simulated"] for row in rows] == ["", "0.0"]
    assert [row["ratio"] for row in rows] == ["", ""]
    assert len(table(tmp_path / "out" / "runs.csv")) == len(names)


def test_another_task_has_another_judge(tmp_path):
    """In the last of the given batches ``b`` is judged, ``a`` is of an earlier version."""
    names = batch_folder(tmp_path, PRESETS)
    judge(tmp_path, names[-3:], [-1.0, -2.0, -3.0])
    found = {group.task: group.measure for group in grouped(runs_below(tmp_path))}
    assert found == {"a": "fitness", "b": HARD}
